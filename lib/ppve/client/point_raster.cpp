#include "ppve/client/point_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ppve/client/point_raster.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/pack-inl.h"

#ifndef LIB_PPVE_POINT_RASTER_ONCE
#define LIB_PPVE_POINT_RASTER_ONCE
namespace ppve {

// A patch and a view, boiled down to what a point needs.
struct PointTask {
    const float *x, *y, *z;
    const uint32_t* colour;
    size_t count;
    float rotation[3][3];                 // view from world
    float at[3];                          // of the anchor
    float footprint, footprint_slope[3];  // times focal length
    float focal, centre_x, centre_y, near, far;
    float scale, most_px;
    bool is_orthographic, is_sized;
    float width, first_row, end_row;
    size_t stride;
    uint64_t* words;
    const uint16_t* normal;                 // null: not shaded
    const uint32_t *factor_of, *colour_of;  // by normal, or null
    bool is_coloured;
    uint32_t one_colour;
    const float* limit;  // PointRaster::cover(); else null
    float* share;
    uint8_t* is_shown;
};

// Splats of a block of points that fall on the raster, as pixels.
struct SplatBlock {
    static constexpr size_t kPoints = 256, kRoom = kPoints + 64;
    alignas(64) int32_t x[kRoom], y[kRoom], x_end[kRoom], y_end[kRoom];
    alignas(64) uint32_t depth[kRoom], number[kRoom];
    alignas(64) float centre_x[kRoom], centre_y[kRoom], size[kRoom];  // of footprints; for coverage only
};

}  // namespace ppve
#endif

HWY_BEFORE_NAMESPACE();
namespace ppve::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Projects points [i, i + lanes), appends those on the raster to the block, returns how many.
template <class D>
HWY_INLINE size_t project(D d, const PointTask& t, size_t i, size_t number, size_t to, SplatBlock& block) {
    using hn::Add, hn::And, hn::Ceil, hn::Div, hn::Ge, hn::Gt, hn::Le, hn::Lt, hn::Max, hn::Min, hn::Mul,
        hn::Set, hn::Sub;
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto x = hn::LoadU(d, t.x + i), y = hn::LoadU(d, t.y + i), z = hn::LoadU(d, t.z + i);
    const auto dot = [&](const float* row, float constant) {
        return Add(Add(Mul(Set(d, row[0]), x), Mul(Set(d, row[1]), y)),
                   Add(Mul(Set(d, row[2]), z), Set(d, constant)));
    };
    const auto vx = dot(t.rotation[0], t.at[0]), vy = dot(t.rotation[1], t.at[1]),
               vz = dot(t.rotation[2], t.at[2]);
    const auto per_depth = t.is_orthographic ? Set(d, 1.0f) : Div(Set(d, 1.0f), vz);
    const auto unscaled = Mul(dot(t.footprint_slope, t.footprint), per_depth);
    const auto per_unit = Mul(Set(d, t.focal), per_depth);
    const auto px = Add(Set(d, t.centre_x), Mul(vx, per_unit)),
               py = Add(Set(d, t.centre_y), Mul(vy, per_unit));
    const auto sized = Min(Max(Mul(unscaled, Set(d, t.scale)), Set(d, 1.0f)), Set(d, kMostSplatPx));
    // Coverage is of the pixels that a footprint overlaps, be it ever so little.
    const auto size = t.limit ? Add(unscaled, Set(d, 1.0f)) : t.is_sized ? sized : Set(d, 1.0f);

    // Pixels with a centre in [p - size / 2, p + size / 2).
    const auto half = Add(Mul(size, Set(d, 0.5f)), Set(d, 0.5f));
    const auto left = Ceil(Sub(px, half)), top = Ceil(Sub(py, half));
    const auto right = Ceil(Sub(Add(px, size), half)), bottom = Ceil(Sub(Add(py, size), half));
    const auto zero = hn::Zero(d), width = Set(d, t.width), first = Set(d, t.first_row),
               end = Set(d, t.end_row);
    // Written so that what is not a number is left out.
    auto seen = And(And(Gt(vz, Set(d, t.near)), Lt(vz, Set(d, t.far))), Le(unscaled, Set(d, t.most_px)));
    seen = And(seen, And(And(Lt(left, width), Gt(right, zero)), And(Lt(top, end), Gt(bottom, first))));
    const core::HWY_NAMESPACE::Pack<D> pack(seen);
    // Whole vectors: a block has room behind its last points.
    const auto store = [&](auto value, auto* out) {
        const hn::Rebind<std::remove_pointer_t<decltype(out)>, D> to_d;
        hn::StoreU(hn::BitCast(to_d, pack.of(hn::BitCast(d, value))), to_d, out + to);
    };
    store(hn::ConvertTo(di, Max(left, zero)), block.x);
    store(hn::ConvertTo(di, Max(top, first)), block.y);
    store(hn::ConvertTo(di, Min(right, width)), block.x_end);
    store(hn::ConvertTo(di, Min(bottom, end)), block.y_end);
    if (t.limit) {
        store(px, block.centre_x);
        store(py, block.centre_y);
        store(unscaled, block.size);
    }
    store(hn::Iota(du, static_cast<uint32_t>(number)), block.number);
    store(vz, block.depth);
    return pack.count();
}

HWY_INLINE uint32_t shade(uint32_t colour, uint32_t factor) {
    const uint32_t red = ((colour & 0xff) * factor + 32768) >> 16;
    const uint32_t green = ((colour >> 8 & 0xff) * factor + 32768) >> 16;
    const uint32_t blue = ((colour >> 16 & 0xff) * factor + 32768) >> 16;
    return red | green << 8 | blue << 16;
}

// Words are finite positive doubles, too, in the same order, of which a minimum is one instruction
// everywhere. kWidth: no splat is wider or higher.
template <int kWidth>
HWY_INLINE void put_small(const PointTask& t, const SplatBlock& block, size_t i, double word) {
    const hn::CappedTag<double, kWidth> d;
    alignas(64) static constexpr double kLast = 0x1.8p+1020;  // above kEmpty
    alignas(64) static constexpr double kOutside[5][4] = {{kLast, kLast, kLast, kLast},
                                                          {0, kLast, kLast, kLast},
                                                          {0, 0, kLast, kLast},
                                                          {0, 0, 0, kLast},
                                                          {0, 0, 0, 0}};
    const double* const outside = kOutside[block.x_end[i] - block.x[i]];
    double* const first =
        reinterpret_cast<double*>(t.words) + size_t(block.y[i]) * t.stride + size_t(block.x[i]);
    const int rows = block.y_end[i] - block.y[i];
    for (int k = 0; k < kWidth; ++k) {
        // The last row again, where there are fewer: no branch.
        double* const row = first + size_t(k < rows ? k : rows - 1) * t.stride;
        for (size_t c = 0; c < size_t(kWidth); c += hn::Lanes(d)) {
            const auto value = hn::Max(hn::Set(d, word), hn::LoadU(d, outside + c));
            hn::StoreU(hn::Min(value, hn::LoadU(d, row + c)), d, row + c);
        }
    }
}

HWY_INLINE void put_large(const PointTask& t, const SplatBlock& block, size_t i, double word) {
    for (int y = block.y[i]; y < block.y_end[i]; ++y) {
        double* const row = reinterpret_cast<double*>(t.words) + size_t(y) * t.stride;
        for (int x = block.x[i]; x < block.x_end[i]; ++x) row[x] = word < row[x] ? word : row[x];
    }
}

template <int kWidth>
HWY_INLINE void put_all(const PointTask& t, const SplatBlock& block, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const uint32_t number = block.number[i];
        uint32_t colour = t.is_coloured ? t.one_colour : t.colour[number];
        if (t.factor_of)
            colour = shade(colour, t.factor_of[t.normal[number]]);
        else if (t.colour_of)
            colour = t.colour_of[t.normal[number]];
        const double word = std::bit_cast<double>(uint64_t(block.depth[i]) << 32 | colour);
        if constexpr (kWidth > 0)
            put_small<kWidth>(t, block, i, word);
        else
            put_large(t, block, i, word);
    }
}

// How much of the pixel [at, at + 1) the interval of the size about the centre overlaps.
HWY_INLINE float overlap(float centre, float size, int at) {
    const float low = std::max(centre - 0.5f * size, float(at));
    const float high = std::min(centre + 0.5f * size, float(at + 1));
    return std::max(0.0f, high - low);
}

void add_coverage(const PointTask& t, const SplatBlock& block, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const float depth = std::bit_cast<float>(block.depth[i]), size = block.size[i];
        const float cx = block.centre_x[i], cy = block.centre_y[i], half = 0.5f * std::max(size, 1.0f);
        for (int y = block.y[i]; y < block.y_end[i]; ++y) {
            const float down = overlap(cy, size, y);
            const bool is_row_shown = std::fabs(cy - float(y) - 0.5f) <= half;
            for (int x = block.x[i]; x < block.x_end[i]; ++x) {
                const size_t pixel = size_t(y) * t.stride + size_t(x);
                if (!(depth <= t.limit[pixel])) continue;
                t.share[pixel] += down * overlap(cx, size, x);
                t.is_shown[pixel] |= is_row_shown && std::fabs(cx - float(x) - 0.5f) <= half;
            }
        }
    }
}

void put(const PointTask& t, const SplatBlock& block, size_t count) {
    if (t.limit) return add_coverage(t, block, count);
    int widest = 0;
    for (size_t i = 0; i < count; ++i)
        widest = std::max({widest, block.x_end[i] - block.x[i], block.y_end[i] - block.y[i]});
    if (widest <= 1)
        put_all<1>(t, block, count);
    else if (widest == 2)
        put_all<2>(t, block, count);
    else if (widest <= 4)
        put_all<4>(t, block, count);
    else
        put_all<0>(t, block, count);
}

size_t draw_points(const PointTask& t) {
    const hn::ScalableTag<float> d;
    const hn::CappedTag<float, 1> one;
    const size_t lanes = hn::Lanes(d);
    SplatBlock block;
    size_t drawn = 0;
    for (size_t begin = 0; begin < t.count; begin += SplatBlock::kPoints) {
        const size_t end = std::min(t.count, begin + SplatBlock::kPoints);
        size_t i = begin, count = 0;
        for (; i + lanes <= end; i += lanes) count += project(d, t, i, i, count, block);
        for (; i < end; ++i) count += project(one, t, i, i, count, block);
        put(t, block, count);
        drawn += count;
    }
    return drawn;
}

}  // namespace ppve::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ppve {

namespace {

HWY_EXPORT(draw_points);

// Depth words as doubles are normal numbers from 2^-118 on.
constexpr double kLeastNear = 1e-30, kMostFar = 1e30;

// The box's middle from the patch's anchor, and half of its size.
glm::dvec3 middle_of(const Patch& patch) {
    return 0.5 * (glm::dvec3(patch.low()) + glm::dvec3(patch.high()));
}

}  // namespace

PointView::PointView(const Frustum& frustum, double unit)
    : projection_(frustum.projection),
      width_(frustum.view.width),
      height_(frustum.view.height),
      unit_(unit),
      eye_(frustum.view.eye),
      right_(frustum.view.right),
      down_(frustum.view.down),
      forward_(frustum.view.forward),
      principal_(frustum.view.principal_in_raster()) {
    const geom::View& view = frustum.view;
    const bool is_orthographic = projection_ == Projection::orthographic;
    focal_ = static_cast<float>(is_orthographic ? view.focal_px * unit : view.focal_px);
    // Depths of an orthographic view may be negative; what is drawn is within the tree, of size 1.
    depth_shift_ = 0;
    double near = view.near ? *view.near / unit : kLeastNear, far = view.far ? *view.far / unit : kMostFar;
    if (is_orthographic) {
        near = view.near ? near : 0, far = view.far ? far : kMostFar;
        depth_shift_ = 1 - near;
        near = 1, far += depth_shift_;
    }
    near_ = static_cast<float>(std::clamp(near, kLeastNear, kMostFar));
    far_ = static_cast<float>(std::clamp(far, kLeastNear, kMostFar));

    const double margin = kMostSplatPx / 2;
    const double left = double(principal_.x) + margin, top = double(principal_.y) + margin;
    const double right = width_ - double(principal_.x) + margin;
    const double bottom = height_ - double(principal_.y) + margin;
    const double focal = double(focal_);
    if (is_orthographic) {
        const glm::dvec3 planes[] = {focal * right_, -focal * right_, focal * down_, -focal * down_};
        const double offsets[] = {left, right, top, bottom};
        std::copy_n(planes, 4, sides_), std::copy_n(offsets, 4, side_offsets_);
    } else {
        const glm::dvec3 planes[] = {focal * right_ + left * forward_, -focal * right_ + right * forward_,
                                     focal * down_ + top * forward_, -focal * down_ + bottom * forward_};
        std::copy_n(planes, 4, sides_), std::fill_n(side_offsets_, 4, 0.0);
    }
}

bool PointView::may_see(const Patch& patch) const {
    const glm::dvec3 middle = (patch.anchor() - eye_) / unit_ + middle_of(patch);
    const glm::dvec3 half = 0.5 * (glm::dvec3(patch.high()) - glm::dvec3(patch.low()));
    const auto most = [&](const glm::dvec3& plane) {
        return glm::dot(plane, middle) + glm::dot(glm::abs(plane), half);
    };
    // Written so that what is not a number is seen.
    for (int k = 0; k < 4; ++k)
        if (most(sides_[k]) + side_offsets_[k] < 0) return false;
    return !(most(forward_) + depth_shift_ < double(near_)) &&
           !(-most(-forward_) + depth_shift_ > double(far_));
}

PointView::Rows PointView::rows_of(const Patch& patch, double most_px) const {
    const glm::dvec3 anchor = (patch.anchor() - eye_) / unit_;
    const glm::dvec3 low(patch.low()), high(patch.high());
    double top = std::numeric_limits<double>::infinity(), bottom = -top;
    for (int k = 0; k < 8; ++k) {
        const glm::dvec3 corner =
            anchor + glm::dvec3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
        const double depth = glm::dot(forward_, corner);
        const bool is_orthographic = projection_ == Projection::orthographic;
        if (!is_orthographic && !(depth > double(near_))) return {0, height_};
        const double y =
            double(principal_.y) + double(focal_) * glm::dot(down_, corner) / (is_orthographic ? 1 : depth);
        if (!std::isfinite(y)) return {0, height_};
        top = std::min(top, y), bottom = std::max(bottom, y);
    }
    const double margin = 0.5 * most_px + 1;  // rounding is far less
    return {static_cast<int>(std::clamp(std::floor(top - margin), 0.0, double(height_))),
            static_cast<int>(std::clamp(std::ceil(bottom + margin), 0.0, double(height_)))};
}

float PointView::splat_px(const Patch& patch) const {
    const glm::dvec3 middle = middle_of(patch);
    const double footprint =
        double(patch.footprint_at_anchor()) + glm::dot(glm::dvec3(patch.footprint_slope()), middle);
    if (projection_ == Projection::orthographic) return static_cast<float>(footprint * double(focal_));
    const double depth = glm::dot(forward_, (patch.anchor() - eye_) / unit_ + middle);
    return depth > double(near_) ? static_cast<float>(footprint * double(focal_) / depth)
                                 : std::numeric_limits<float>::infinity();
}

float PointView::most_splat_px(const Patch& patch) const {
    const glm::dvec3 middle = middle_of(patch), half = glm::dvec3(patch.high()) - middle;
    const glm::dvec3 slope(patch.footprint_slope());
    const double footprint =
        double(patch.footprint_at_anchor()) + glm::dot(slope, middle) + glm::dot(glm::abs(slope), half);
    if (projection_ == Projection::orthographic) return static_cast<float>(footprint * double(focal_));
    const double nearest =
        glm::dot(forward_, (patch.anchor() - eye_) / unit_ + middle) - glm::dot(glm::abs(forward_), half);
    return nearest > double(near_) ? static_cast<float>(footprint * double(focal_) / nearest)
                                   : std::numeric_limits<float>::infinity();
}

glm::vec3 PointView::at(const Patch& patch) const {
    const glm::dvec3 from_eye = (patch.anchor() - eye_) / unit_;
    return {glm::dot(right_, from_eye), glm::dot(down_, from_eye),
            glm::dot(forward_, from_eye) + depth_shift_};
}

void PointRaster::resize(int width, int height) {
    width_ = width, height_ = height;
    // Splats are drawn four pixels at a time, the last ones of which may lie beside the raster.
    stride_ = size_t(width) + 3;
    words_.resize(stride_ * size_t(height));
}

void PointRaster::clear(int first, int end) {
    std::fill(words_.begin() + std::ptrdiff_t(stride_) * first,
              words_.begin() + std::ptrdiff_t(stride_) * end, kEmpty);
}

size_t PointRaster::draw(const PointView& view, const Patch& patch, const PatchStyle& style,
                         const PointShading& shading, int first, int end) {
    return draw(view, patch, patch.points(), 1, style, shading, first, end);
}

PointTask PointRaster::task_of(const PointView& view, const Patch& patch, const PatchPoints& points,
                               float coarseness, int first, int end) {
    PointTask task{};
    task.x = points.x.data(), task.y = points.y.data(), task.z = points.z.data();
    task.colour = points.colour.data();
    task.count = points.size();
    const glm::dvec3* const rows[] = {&view.right_, &view.down_, &view.forward_};
    const glm::vec3 at = view.at(patch);
    const float focal = view.focal_ * coarseness;
    for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) task.rotation[k][c] = static_cast<float>((*rows[k])[c]);
        task.at[k] = at[k];
        task.footprint_slope[k] = patch.footprint_slope()[k] * focal;
    }
    task.footprint = patch.footprint_at_anchor() * focal;
    task.focal = view.focal_;
    task.centre_x = view.principal_.x, task.centre_y = view.principal_.y;
    task.near = view.near_, task.far = view.far_;
    task.is_orthographic = view.projection_ == Projection::orthographic;
    task.width = float(view.width_), task.first_row = float(first), task.end_row = float(end);
    return task;
}

size_t PointRaster::draw(const PointView& view, const Patch& patch, const PatchPoints& points,
                         float coarseness, const PatchStyle& style, const PointShading& shading, int first,
                         int end) {
    PointTask task = task_of(view, patch, points, coarseness, first, end);
    task.scale = style.scale, task.most_px = style.most_px, task.is_sized = style.is_sized;
    task.stride = stride_, task.words = words_.data();
    task.is_coloured = style.is_coloured;
    task.one_colour = style.colour.x | uint32_t(style.colour.y) << 8 | uint32_t(style.colour.z) << 16;
    if (points.has_normals()) {
        task.normal = points.normal.data();
        if (!shading.factor.empty()) task.factor_of = shading.factor.data();
        if (!shading.colour.empty()) task.colour_of = shading.colour.data();
    }
    return HWY_DYNAMIC_DISPATCH(draw_points)(task);
}

void PointRaster::cover(const PointView& view, const Patch& patch, float most_px,
                        const std::vector<float>& limit, Coverage& coverage, int first, int end) {
    PointTask task = task_of(view, patch, patch.points(), 1, first, end);
    task.most_px = most_px;
    task.stride = size_t(view.width());
    task.limit = limit.data();
    task.share = coverage.share.data(), task.is_shown = coverage.is_shown.data();
    HWY_DYNAMIC_DISPATCH(draw_points)(task);
}

}  // namespace ppve

#endif
