// Set-up of splats, as many at a time as the machine's vectors hold.
#include "render/splat_record.h"

#include <algorithm>
#include <bit>
#include <cmath>

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/splat_setup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/shading-inl.h"
#include "render/splat_outline-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// No radius in pixels is less: squares of it stay within float.
constexpr float kMinRadiusPx = 1.0e-5f;

// Offset of pixel `first` from the outline's centre.  The centre comes in double: at pixel 1000 a float has
// but 6e-5 px, too coarse for the smallest splats.
HWY_INLINE V offset_px(V first, DoubleLanes projected, V centre_shift, double principal) {
    const DoubleLanes p = add(promote(first), 0.5 - principal);
    return hn::Sub(demote({hn::Sub(p.low, projected.low), hn::Sub(p.high, projected.high)}), centre_shift);
}

HWY_INLINE hn::Vec<U> pack_cores(V a, V b) {
    const hn::RebindToSigned<F> di;
    const auto ai = hn::BitCast(U(), hn::ConvertTo(di, a));
    const auto bi = hn::BitCast(U(), hn::ConvertTo(di, b));
    return hn::Or(hn::And(ai, hn::Set(U(), 0xffffu)), hn::ShiftLeft<16>(bi));
}

// The sphere of its radius meets all four half-spaces that bound the raster.
bool may_be_seen(const geom::View& view, double x, double y, double z, double radius) {
    const glm::dvec2 principal = view.principal_in_raster();
    // How far the centre is beyond the side where f * coordinate = place * z.
    const auto off = [&](double coordinate, double place) {
        return (coordinate * view.focal_px - place * z) / std::hypot(view.focal_px, place);
    };
    return off(-x, principal.x) <= radius && off(x, view.width - principal.x) <= radius &&
           off(-y, principal.y) <= radius && off(y, view.height - principal.y) <= radius;
}

struct PixelBox {
    uint16_t x0, y0, x1, y1;
};

NearSplat near_splat(const SplatChunk& chunk, size_t i, const PixelBox& box, uint32_t colour) {
    const float *place = chunk.place + 4 * i, *facing = chunk.facing + 4 * i;
    const double inverse = 1.0 / static_cast<double>(place[3]);
    const float c = std::max(facing[3], kMinFlatness);
    return {box.x0,
            box.y0,
            box.x1,
            box.y1,
            static_cast<float>(place[0] * inverse),
            static_cast<float>(place[1] * inverse),
            static_cast<float>(place[2] * inverse),
            facing[0],
            facing[1],
            facing[2],
            c * c,
            static_cast<float>(inverse),
            colour};
}

// Material of each splat: what `smooth` blends, and what the others are shaded with.
HWY_INLINE Rgb<V> material_of(bool has_colour, hn::Vec<U> colour) {
    const F d;
    if (has_colour) return unpack_rgb(d, colour);
    const V grey = hn::Set(d, kGreyMaterial);
    return {grey, grey, grey};
}

// Records lie as four vectors of four floats; this is how many lanes there are of each.
template <class Visible>
HWY_INLINE size_t write_records(const V (&fields)[16], Visible visible, SplatRecord* out) {
    const F d;
#if HWY_TARGET == HWY_SCALAR
    if (hn::AllFalse(d, visible)) return 0;
    for (size_t f = 0; f < 16; ++f) hn::Store(fields[f], d, reinterpret_cast<float*>(out) + f);
    return 1;
#else
    alignas(64) float quarters[4][4 * kMaxLanes];
    for (size_t q = 0; q < 4; ++q) {
        hn::StoreInterleaved4(fields[4 * q], fields[4 * q + 1], fields[4 * q + 2], fields[4 * q + 3], d,
                              quarters[q]);
    }
    size_t count = 0;
    for (uint32_t bits = mask_bits(visible); bits != 0; bits &= bits - 1) {
        const size_t lane = static_cast<size_t>(std::countr_zero(bits));
        float* record = reinterpret_cast<float*>(out + count++);
        const hn::FixedTag<float, 4> quarter;
        for (size_t q = 0; q < 4; ++q) {
            hn::Store(hn::Load(quarter, quarters[q] + 4 * lane), quarter, record + 4 * q);
        }
    }
    return count;
#endif
}

// See kReach.  length: of (tx, ty, 1).
HWY_INLINE V reach_of(V tx, V ty, V length, V nx, V ny, V nz, V flatness) {
    const F d;
    const V along_normal = hn::Abs(hn::Add(hn::Add(hn::Mul(nx, tx), hn::Mul(ny, ty)), nz));
    const V reach = hn::Add(hn::Set(d, kReach), hn::Mul(hn::Set(d, kReachByFlatness), flatness));
    return hn::Min(hn::Set(d, 1.0f),
                   hn::Div(hn::Mul(reach, length), hn::Max(along_normal, hn::Set(d, 1.0e-6f))));
}

size_t set_up_splats(const SetupParams& params, const SplatChunk& chunk, size_t count,
                     const uint32_t* colours, SplatRecord* out, std::vector<NearSplat>& near_splats) {
    const F d;
    const U du;
    const geom::View& view = params.view;
    const SplatterOptions& options = params.options;
    const bool aligned = options.kind == SplatKind::square || options.kind == SplatKind::circle;
    const bool blended = options.kind == SplatKind::smooth;
    const bool has_colour = options.has_colour || options.look.shade == Shade::level;
    const float focal = static_cast<float>(view.focal_px);
    // All that becomes part of a record is about the picture, so that it does not depend on the raster.
    const glm::dvec2 principal = view.principal();
    const int width = view.picture_width(), height = view.picture_height();
    size_t written = 0;

    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        V x, y, z, radius, nx, ny, nz, flatness;
        hn::LoadInterleaved4(d, chunk.place + 4 * i, x, y, z, radius);
        hn::LoadInterleaved4(d, chunk.facing + 4 * i, nx, ny, nz, flatness);
        const DoubleLanes zd = promote(z);
        const auto one_d = hn::Set(DF(), 1.0);
        const DoubleLanes inverse_zd = {hn::Div(one_d, zd.low), hn::Div(one_d, zd.high)};
        const DoubleLanes txd = multiply(promote(x), inverse_zd);
        const DoubleLanes tyd = multiply(promote(y), inverse_zd);
        const DoubleLanes projected_x = scale(txd, view.focal_px), projected_y = scale(tyd, view.focal_px);
        const V inverse_z = demote(inverse_zd);
        const V r = hn::Mul(radius, inverse_z);
        const V radius_px = hn::Max(hn::Mul(r, hn::Set(d, focal)), hn::Set(d, kMinRadiusPx));

        const Outline o = aligned ? aligned_outline(inverse_z, radius_px, options.kind == SplatKind::square)
                                  : ellipsoid_outline(focal, demote(txd), demote(tyd), inverse_z, r,
                                                      radius_px, nx, ny, nz, flatness);

        const PixelRange xs = pixel_range(
            hn::Add(hn::Add(demote(projected_x), o.centre_dx), hn::Set(d, static_cast<float>(principal.x))),
            o.extent_x, 0, width);
        const PixelRange ys = pixel_range(
            hn::Add(hn::Add(demote(projected_y), o.centre_dy), hn::Set(d, static_cast<float>(principal.y))),
            o.extent_y, 0, height);
        const auto valid = hn::FirstN(d, count - i);
        const auto before_eye = hn::Gt(z, hn::Zero(d));
        const auto clear = hn::Gt(o.clearance, hn::Set(d, kMinClearance));
        const auto visible = hn::And(hn::And(valid, hn::And(before_eye, clear)), hn::And(xs.any, ys.any));

        // Of splats without colour nobody wrote any: reading it would wait for memory.
        const auto given = has_colour ? hn::Load(du, colours + i) : hn::Zero(du);
        const auto colour = blended ? given
                                    : shade_points(d, options.look.shade, params.light, nx, ny, nz,
                                                   material_of(has_colour, given));

        // 1/z - 1/(z + R cos): R along the ray, which off the axis is less of depth.  A push of 0 makes the
        // aligned kinds a plain depth test.
        const V tx = demote(txd), ty = demote(tyd), one = hn::Set(d, 1.0f);
        const V length = hn::Sqrt(hn::Add(one, hn::Add(hn::Mul(tx, tx), hn::Mul(ty, ty))));
        const V along_ray = hn::Div(r, length);
        V push = aligned ? hn::Zero(d) : hn::Mul(inverse_z, hn::Div(along_ray, hn::Add(one, along_ray)));
        if (blended) push = hn::Mul(push, reach_of(tx, ty, length, nx, ny, nz, flatness));
        const V fields[16] = {hn::BitCast(d, pack_pixels(xs.first, ys.first)),
                              hn::BitCast(d, pack_pixels(xs.last, ys.last)),
                              offset_px(xs.first, projected_x, o.centre_dx, principal.x),
                              offset_px(ys.first, projected_y, o.centre_dy, principal.y),
                              o.l1,
                              o.l2,
                              o.l3,
                              push,
                              o.w,
                              o.w_dx,
                              o.w_dy,
                              hn::BitCast(d, colour),
                              nx,
                              ny,
                              nz,
                              hn::BitCast(d, pack_cores(o.core_a, o.core_b))};
        written += write_records(fields, visible, out + written);

        if (aligned) continue;
        // Written so that a clearance that is no number (z of 0) takes the careful way.
        const auto behind = hn::AndNot(before_eye, hn::Ge(o.clearance, hn::Zero(d)));
        const auto careful = hn::AndNot(hn::Or(behind, hn::And(before_eye, clear)), valid);
        if (hn::AllFalse(d, careful)) continue;
        const auto bounded = hn::And(before_eye, hn::Gt(o.clearance, hn::Set(d, kMinBoundedClearance)));
        const auto off_screen = hn::AndNot(hn::And(xs.any, ys.any), bounded);
        alignas(64) float x0[kMaxLanes], y0[kMaxLanes], x1[kMaxLanes], y1[kMaxLanes];
        alignas(64) uint32_t lane_colours[kMaxLanes];
        hn::Store(hn::IfThenElseZero(bounded, xs.first), d, x0);
        hn::Store(hn::IfThenElseZero(bounded, ys.first), d, y0);
        hn::Store(hn::IfThenElse(bounded, xs.last, hn::Set(d, static_cast<float>(width - 1))), d, x1);
        hn::Store(hn::IfThenElse(bounded, ys.last, hn::Set(d, static_cast<float>(height - 1))), d, y1);
        hn::Store(colour, du, lane_colours);
        for (uint32_t bits = mask_bits(hn::AndNot(off_screen, careful)); bits != 0; bits &= bits - 1) {
            const size_t lane = static_cast<size_t>(std::countr_zero(bits)), k = i + lane;
            const float* place = chunk.place + 4 * k;
            if (!may_be_seen(view, place[0], place[1], place[2], place[3])) continue;
            const PixelBox seen{uint16_t(x0[lane]), uint16_t(y0[lane]), uint16_t(x1[lane]),
                                uint16_t(y1[lane])};
            near_splats.push_back(near_splat(chunk, k, seen, lane_colours[lane]));
        }
    }
    return written;
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(set_up_splats);

namespace {

// Shade::level colours a splat by its size.
uint32_t colour_of_level(const SetupParams& params, float z, float radius) {
    const double focal_px = params.view.focal_px / params.options.look.samples_across;
    const double diameter = 2.0 * focal_px * radius / std::abs(double(z));
    const glm::u8vec3 c = level_colour(static_cast<float>(std::min(diameter, 1.0e6)));
    return uint32_t(c.r) | uint32_t(c.g) << 8 | uint32_t(c.b) << 16;
}

}  // namespace

size_t set_up_splats(const SetupParams& params, const SplatChunk& chunk, const ColourChunk& colours,
                     size_t count, SplatRecord* out, std::vector<NearSplat>& near_splats) {
    ColourChunk levels;
    if (params.options.look.shade == Shade::level) {
        for (size_t i = 0; i < count; ++i)
            levels.of[i] = colour_of_level(params, chunk.place[4 * i + 2], chunk.place[4 * i + 3]);
    }
    const ColourChunk& shown = params.options.look.shade == Shade::level ? levels : colours;
    return HWY_DYNAMIC_DISPATCH(set_up_splats)(params, chunk, count, shown.of, out, near_splats);
}

}  // namespace render
#endif
