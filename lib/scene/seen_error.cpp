#include "scene/seen_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace scene {

namespace {

using Splat = splat::LargestErrors::Splat;

// Wider ones are not looked for: they can be seen, or take longer than they are worth.
constexpr double kWidestPx = 64;

// What a splat shows is within its sphere, but for rounding: of the sphere, and of depths.
constexpr double kReach = 1.05, kDepthRounding = 1e-5;

// Whether all pixels that the splat may reach show something before it.
bool is_hidden(const Splat& splat, double unit, const geom::View& view, const render::Frame& frame) {
    const glm::dvec3 centre = unit * glm::dvec3(splat.centre);
    const double reach = kReach * unit * double(splat.radius),
                 nearest = (1 - kDepthRounding) * centre.z - reach;
    if (!(nearest > 0)) return false;
    // Beyond the tangents from the eye: all is projected from the sphere's nearest depth.
    const double half_px = 1 + view.focal_px * (reach + reach * glm::length(centre) / centre.z) / nearest;
    if (!(half_px < kWidestPx)) return false;
    const glm::dvec2 middle = view.principal_in_raster() + view.focal_px / centre.z * glm::dvec2(centre);
    const auto first = [](double at) { return int(std::floor(at)); };
    const auto inside = [](double at, int size) { return std::clamp(at, -1.0, double(size)); };
    const int x0 = std::max(0, first(inside(middle.x - half_px, frame.width))),
              x1 = std::min(frame.width - 1, first(inside(middle.x + half_px, frame.width))),
              y0 = std::max(0, first(inside(middle.y - half_px, frame.height))),
              y1 = std::min(frame.height - 1, first(inside(middle.y + half_px, frame.height)));
    for (int y = y0; y <= y1; ++y) {
        const float* const row = frame.depth.data() + size_t(y) * size_t(frame.width);
        if (std::any_of(row + x0, row + x1 + 1, [&](float depth) { return !(double(depth) < nearest); }))
            return false;
    }
    return true;
}

}  // namespace

double seen_error_px(const splat::CutCounts& counts, double unit, const geom::View& view,
                     const render::Frame& frame) {
    const splat::LargestErrors& largest = counts.largest;
    std::vector<Splat> splats(largest.splats().begin(), largest.splats().end());
    std::sort(splats.begin(), splats.end(),
              [](const Splat& a, const Splat& b) { return a.error_px > b.error_px; });
    const auto seen = std::find_if(splats.begin(), splats.end(),
                                   [&](const Splat& splat) { return !is_hidden(splat, unit, view, frame); });
    if (seen != splats.end()) return std::max(counts.other_error_px, double(seen->error_px));
    // Those that were not kept are no larger than the least of them.
    const bool is_full = splats.size() == splat::LargestErrors::kMost;
    return std::max(counts.other_error_px, is_full ? double(splats.back().error_px) : 0.0);
}

}  // namespace scene
