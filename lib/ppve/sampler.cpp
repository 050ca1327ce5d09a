#include "ppve/sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppve {

namespace {

// What is nearer to an eye within the scene, in parts of the farthest depth, is drawn as if it were there:
// 100 octaves leave room for 23 bits of mantissa in a code.
constexpr double kNearestPart = 0x1p-100;

}  // namespace

void Box::add(const glm::dvec3& point) {
    low = is_empty ? point : glm::min(low, point);
    high = is_empty ? point : glm::max(high, point);
    is_empty = false;
}

geom::Sphere Box::sphere() const {
    return {0.5 * (low + high), 0.5 * glm::length(high - low)};
}

std::array<geom::Sphere, 8> Box::corners() const {
    std::array<geom::Sphere, 8> corners{};
    for (size_t k = 0; k < corners.size(); ++k)
        for (int axis = 0; axis < 3; ++axis) corners[k].centre[axis] = k >> axis & 1 ? high[axis] : low[axis];
    return corners;
}

DepthRange depths_in(const Frustum& frustum, const Box& box) {
    if (box.is_empty) return {};
    const geom::View& v = frustum.view;
    DepthRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                     false};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                            corner & 4 ? box.high.z : box.low.z);
        const double depth = v.view_from_world(at).z;
        range.nearest = std::min(range.nearest, depth), range.farthest = std::max(range.farthest, depth);
    }
    // By more than depths are rounded on the way: what lies on the box's side is in the range.
    const glm::dvec3 reach = glm::abs(v.eye) + glm::max(glm::abs(box.low), glm::abs(box.high));
    const double rounding = 0x1p-48 * (reach.x + reach.y + reach.z);
    range.nearest -= rounding, range.farthest += rounding;
    if (v.near) range.nearest = std::max(range.nearest, *v.near);
    if (v.far) range.farthest = std::min(range.farthest, *v.far);
    if (frustum.projection == Projection::perspective) {
        range.farthest = std::min(range.farthest, kMostDepth);
        range.nearest = std::max({range.nearest, range.farthest * kNearestPart, kLeastDepth});
    }
    range.is_empty = !(range.nearest <= range.farthest);
    return range;
}

void prepare(const Sampler& sampler, double bound_px, DepthImage& image) {
    const DepthRange range = depths_in(image.frustum, sampler.bounds());
    image.coding = range.is_empty ? choose_coding(image.frustum, bound_px, 1, 1)
                                  : choose_coding(image.frustum, bound_px, range.nearest, range.farthest);
}

}  // namespace ppve
