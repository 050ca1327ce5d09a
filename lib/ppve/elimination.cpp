#include "ppve/elimination.h"

#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/bytes.h"
#include "core/error.h"
#include "core/parallel.h"
#include "ppve/client/point_raster.h"

namespace ppve {

using core::text;

namespace {

// A steeper slope is a silhouette: what lies behind is another surface.
constexpr double kMostSlope = 30;  // footprints a pixel

// Depths of cached points are single precision, positions somewhat worse; counts in very narrow frusta only.
constexpr double kRounding = 0x1p-21;

// Of a pixel that footprints must overlap together for its sample to be left out, beside a splat that is
// drawn there: one alone may stand for a surface that is hardly sampled.  Against 0.5, pictures in motion
// lose 0.8 dB with 0.4 and gain 0.2 dB with 0.6, but then 1.3% of a walk's points are duplicates
// (point_view_bench).
constexpr float kEnough = 0.5f;

// A patch and its place, of those in the frustum.
struct PlacedPatch {
    const Patch* patch;
    ClusterId cluster;
    uint32_t index;
    PointView::Rows rows;
};

// Points reach over `most_px` pixels at most.
std::vector<PlacedPatch> patches_in(const Octree& tree, const PointView& view, double most_px) {
    std::vector<PlacedPatch> patches;
    tree.for_each([&](const Cluster& cluster) {
        for (size_t k = cluster.patches.size(); k-- > 0;) {
            const Patch& patch = *cluster.patches[k];
            if (!view.may_see(patch)) continue;
            patches.push_back({&patch, cluster.id, static_cast<uint32_t>(k), view.rows_of(patch, most_px)});
        }
    });
    return patches;
}

// draw(patch, first row, end) in parallel, by rows that nobody else draws in, and in the order of the
// patches.
template <class Draw>
void for_each_band(const std::vector<PlacedPatch>& patches, int rows, const Draw& draw) {
    const size_t bands = size_t(core::thread_count());
    core::parallel_for(bands, [&](size_t band) {
        const int first = int(size_t(rows) * band / bands), end = int(size_t(rows) * (band + 1) / bands);
        for (const PlacedPatch& placed : patches)
            if (placed.rows.first < end && placed.rows.end > first) draw(placed, first, end);
    });
}

// Depths of the new image before anything is left out, and how they change from pixel to pixel.
struct DepthField {
    int width, height;
    std::vector<float> depth;  // NaN: nothing there
    std::vector<float> slope;  // a pixel

    explicit DepthField(const DepthImage& image);
    bool is_there(int x, int y) const { return !std::isnan(depth[size_t(y) * size_t(width) + size_t(x)]); }
    double at(int x, int y) const { return double(depth[size_t(y) * size_t(width) + size_t(x)]); }
    // The smaller of the differences to both sides: the larger may be to another surface.
    float side_slope(int x, int y, int dx, int dy) const;
};

float DepthField::side_slope(int x, int y, int dx, int dy) const {
    float least = std::numeric_limits<float>::infinity();
    for (const int sign : {-1, 1}) {
        const int nx = x + sign * dx, ny = y + sign * dy;
        if (nx < 0 || ny < 0 || nx >= width || ny >= height || !is_there(nx, ny)) continue;
        least = std::min(least, static_cast<float>(std::fabs(at(nx, ny) - at(x, y))));
    }
    return std::isfinite(least) ? least : 0;
}

DepthField::DepthField(const DepthImage& image)
    : width(image.width()), height(image.height()), depth(image.pixels()), slope(image.pixels()) {
    core::parallel_for(
        size_t(height),
        [&](size_t y) {
            for (size_t i = y * size_t(width); i < (y + 1) * size_t(width); ++i)
                depth[i] = image.depth[i] != 0 ? static_cast<float>(image.coding.depth(image.depth[i]))
                                               : std::numeric_limits<float>::quiet_NaN();
        },
        16);
    core::parallel_for(
        size_t(height),
        [&](size_t y) {
            for (int x = 0; x < width; ++x) {
                if (!is_there(x, int(y))) continue;
                const double most = kMostSlope * footprint(image.frustum, image.footprint_px, at(x, int(y)));
                const float steeper = std::max(side_slope(x, int(y), 1, 0), side_slope(x, int(y), 0, 1));
                slope[y * size_t(width) + size_t(x)] = static_cast<float>(std::min(double(steeper), most));
            }
        },
        16);
}

// How far off a sample may be from one that is the same, from its own depth on.
double epsilon_of(const DepthImage& image, const DepthField& field, size_t pixel, double z) {
    return footprint(image.frustum, image.footprint_px, z) + double(field.slope[pixel]) +
           kRounding * std::fabs(z);
}

// What the tree's points hold of each pixel in front of the new sample, or no farther behind it than epsilon;
// points of more than `most_px` pixels left out.
Coverage coverage_of(const std::vector<PlacedPatch>& patches, const PointView& view, float most_px,
                     const DepthImage& image, const DepthField& field) {
    std::vector<float> limit(image.pixels());
    Coverage coverage(image.pixels());
    core::parallel_for(
        size_t(field.height),
        [&](size_t y) {
            for (size_t i = y * size_t(field.width); i < (y + 1) * size_t(field.width); ++i)
                if (const double z = double(field.depth[i]); !std::isnan(z))
                    limit[i] = view.depth_key(z + epsilon_of(image, field, i, z));
        },
        16);
    for_each_band(patches, view.height(), [&](const PlacedPatch& placed, int first, int end) {
        PointRaster::cover(view, *placed.patch, most_px, limit, coverage, first, end);
    });
    return coverage;
}

// The paper's reference map: the nearest of all points, one pixel each.
PointRaster reference_of(const std::vector<PlacedPatch>& patches, const PointView& view) {
    PointRaster raster;
    raster.resize(view.width(), view.height());
    raster.clear(0, view.height());
    PatchStyle style;
    style.is_sized = false;
    for_each_band(patches, view.height(), [&](const PlacedPatch& placed, int first, int end) {
        raster.draw(view, *placed.patch, style, {}, first, end);
    });
    return raster;
}

void leave_out(DepthImage& image, size_t pixel) {
    image.depth[pixel] = image.colour[pixel] = 0;
    if (!image.normal.empty()) image.normal[pixel] = 0;
}

// body(y) leaves out samples of a row and says how many of those that it left out are lost.
template <class Body>
uint64_t eliminate_rows(const DepthImage& image, const Body& body) {
    std::vector<uint64_t> lost(size_t(image.height()));
    core::parallel_for(
        lost.size(), [&](size_t y) { lost[y] = body(y); }, 16);
    return std::accumulate(lost.begin(), lost.end(), uint64_t(0));
}

// Whether the new samples hold the point's whole footprint: its corners and its middle, each within the
// footprint of its depth.
bool is_replaced(const DepthImage& image, const DepthField& field, const glm::dvec3& world, double extent,
                 double rho) {
    const Projected at = project(image.frustum, world);
    if (image.frustum.projection == Projection::perspective && !(at.depth > 0)) return false;
    const double pixel = footprint(image.frustum, 1, at.depth);
    if (!(extent > rho * image.footprint_px * pixel)) return false;
    const double half = 0.5 * extent / pixel;
    constexpr double kProbes[5][2] = {{0, 0}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    for (const auto& probe : kProbes) {
        const double px = std::floor(at.x + half * probe[0]), py = std::floor(at.y + half * probe[1]);
        if (!(px >= 0 && px < field.width && py >= 0 && py < field.height)) return false;
        const int x = int(px), y = int(py);
        if (!field.is_there(x, y)) return false;
        const double slope = double(field.slope[size_t(y) * size_t(field.width) + size_t(x)]);
        if (std::fabs(field.at(x, y) - at.depth) > extent + slope * half) return false;
    }
    return true;
}

Removal replaced_points(const PlacedPatch& placed, double unit, double rho, const DepthImage& image,
                        const DepthField& field) {
    const Patch& patch = *placed.patch;
    const PatchPoints& points = patch.points();
    Removal removal{placed.cluster, placed.index, std::vector<uint8_t>(patch.size())};
    for (size_t i = 0; i < patch.size(); ++i) {
        const glm::vec3 offset(points.x[i], points.y[i], points.z[i]);
        const double extent =
            unit * double(patch.footprint_at_anchor() + glm::dot(patch.footprint_slope(), offset));
        removal.is_removed[i] =
            is_replaced(image, field, patch.anchor() + glm::dvec3(offset) * unit, extent, rho);
    }
    return removal;
}

std::vector<Removal> find_replaced(const std::vector<PlacedPatch>& patches, const PointView& view,
                                   double unit, double rho, const DepthImage& image,
                                   const DepthField& field) {
    std::vector<Removal> removals(patches.size());
    const float coarse_px = static_cast<float>(rho * image.footprint_px);
    core::parallel_for(patches.size(), [&](size_t k) {
        if (view.most_splat_px(*patches[k].patch) > coarse_px)
            removals[k] = replaced_points(patches[k], unit, rho, image, field);
    });
    std::erase_if(removals, [](const Removal& removal) {
        return std::find(removal.is_removed.begin(), removal.is_removed.end(), 1) == removal.is_removed.end();
    });
    return removals;
}

}  // namespace

Eliminated eliminate(const Octree& tree, const EliminationRule& rule, DepthImage& image) {
    Eliminated result;
    result.counts.samples = result.counts.kept = image.samples();
    if (rule.kind == Elimination::none) return result;
    const PointView view(image.frustum, tree.shape().unit());
    const float coarse_px = static_cast<float>(rule.rho * image.footprint_px);
    const std::vector<PlacedPatch> patches = patches_in(tree, view, double(coarse_px) + 1);
    const DepthField field(image);
    const Coverage coverage = coverage_of(patches, view, coarse_px, image, field);
    const float enough = kEnough * static_cast<float>(image.footprint_px * image.footprint_px);
    if (rule.kind == Elimination::filtered) {
        result.removed = find_replaced(patches, view, tree.shape().unit(), rule.rho, image, field);
        eliminate_rows(image, [&](size_t y) {
            for (size_t i = y * size_t(field.width); i < (y + 1) * size_t(field.width); ++i)
                if (coverage.is_shown[i] && coverage.share[i] >= enough) leave_out(image, i);
            return 0;
        });
    } else {
        const PointRaster reference = reference_of(patches, view);
        result.counts.lost = eliminate_rows(image, [&](size_t y) {
            uint64_t lost = 0;
            for (size_t x = 0; x < size_t(field.width); ++x) {
                const size_t i = y * size_t(field.width) + x;
                const double z = double(field.depth[i]);
                const uint64_t word = reference.row(int(y))[x];
                if (image.depth[i] == 0 || word == PointRaster::kEmpty ||
                    z < view.depth_of(word) - rule.epsilon)
                    continue;
                lost += coverage.share[i] == 0;
                leave_out(image, i);
            }
            return lost;
        });
    }
    result.counts.kept = image.samples();
    for (const Removal& removal : result.removed)
        result.counts.removed +=
            uint64_t(std::count(removal.is_removed.begin(), removal.is_removed.end(), 1));
    return result;
}

// A count, then cluster, patch and points of each, then the bits of all, each from a byte of its own.
std::vector<std::byte> write_removals(std::span<const Removal> removals) {
    if (removals.empty()) return {};
    core::ByteWriter raw;
    raw.put(static_cast<uint32_t>(removals.size()));
    for (const Removal& removal : removals) {
        raw.put(removal.cluster);
        raw.put(removal.patch);
        raw.put(static_cast<uint32_t>(removal.is_removed.size()));
    }
    for (const Removal& removal : removals) {
        std::vector<std::byte> bits((removal.is_removed.size() + 7) / 8);
        for (size_t i = 0; i < removal.is_removed.size(); ++i)
            bits[i / 8] |= static_cast<std::byte>(removal.is_removed[i] << i % 8);
        raw.bytes.insert(raw.bytes.end(), bits.begin(), bits.end());
    }
    std::vector<std::byte> out(ZSTD_compressBound(raw.bytes.size()));
    const size_t size = ZSTD_compress(out.data(), out.size(), raw.bytes.data(), raw.bytes.size(), 1);
    if (ZSTD_isError(size)) throw core::Error(text("removed points: %s", ZSTD_getErrorName(size)));
    out.resize(size);
    return out;
}

namespace {

std::vector<std::byte> decompressed(std::span<const std::byte> bytes, uint64_t most_bytes) {
    const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
    if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN)
        throw core::Error("removed points: are not a zstd frame of a known size");
    if (size > most_bytes)
        throw core::Error(text("removed points: are %llu bytes, and can be %llu at most", size,
                               static_cast<unsigned long long>(most_bytes)));
    std::vector<std::byte> raw(size);
    const size_t done = ZSTD_decompress(raw.data(), raw.size(), bytes.data(), bytes.size());
    if (ZSTD_isError(done)) throw core::Error(text("removed points: %s", ZSTD_getErrorName(done)));
    if (done != raw.size())
        throw core::Error(text("removed points: are %zu bytes, expected %zu", done, raw.size()));
    return raw;
}

}  // namespace

std::vector<Removal> read_removals(std::span<const std::byte> bytes, uint64_t most_points) {
    if (bytes.empty()) return {};
    constexpr uint64_t kEntryBytes = 16;
    const std::vector<std::byte> raw = decompressed(bytes, 4 + (kEntryBytes + 1) * most_points);
    core::ByteReader reader(raw, "removed points");
    const uint64_t count = reader.take<uint32_t>();
    if (count * kEntryBytes > raw.size() - reader.position())
        throw core::Error(text("removed points: %zu bytes cannot hold %llu patches", raw.size(),
                               static_cast<unsigned long long>(count)));
    std::vector<Removal> removals(count);
    uint64_t points = 0;
    for (Removal& removal : removals) {
        removal.cluster = reader.take<uint64_t>();
        removal.patch = reader.take<uint32_t>();
        const uint32_t size = reader.take<uint32_t>();
        points += size;
        if (points > most_points)
            throw core::Error(text("removed points: of %llu points, there are %llu",
                                   static_cast<unsigned long long>(points),
                                   static_cast<unsigned long long>(most_points)));
        removal.is_removed.resize(size);
    }
    for (Removal& removal : removals)
        for (size_t i = 0; i < removal.is_removed.size(); i += 8) {
            const auto bits = reader.take<uint8_t>();
            for (size_t k = 0; k < 8; ++k) {
                const uint8_t bit = bits >> k & 1;
                if (i + k < removal.is_removed.size())
                    removal.is_removed[i + k] = bit;
                else if (bit != 0)
                    throw core::Error("removed points: bits beyond the last point are set");
            }
        }
    if (reader.position() != raw.size())
        throw core::Error(text("removed points: end at byte %zu of %zu", reader.position(), raw.size()));
    return removals;
}

}  // namespace ppve
