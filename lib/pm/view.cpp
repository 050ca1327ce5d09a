#include "pm/view.h"

#include <cmath>
#include <limits>

#include "core/error.h"

namespace pm {

namespace {

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// True where nothing within `radius` of a point at `offset` from the eye can face it.  Seen from the eye the
// sphere spreads the direction by asin(radius / distance) and the cone spreads the normal by its half angle;
// the two can be off in the same direction, so the angles add.
bool is_turned_away(const Cone& cone, const glm::dvec3& offset, double distance, double radius) {
    if (!(distance > radius)) return false;
    const double sine = radius / distance, cosine = std::sqrt(1 - sine * sine);
    if (!(cone.cosine * cosine > cone.sine * sine)) return false;  // together 90 degrees or more
    return glm::dot(cone.axis, offset) > distance * (cone.sine * cosine + cone.cosine * sine);
}

}  // namespace

View make_view(const geom::View& from, double threshold_px) {
    View view;
    view.eye = from.eye;
    view.right = from.right, view.down = from.down, view.forward = from.forward;
    const glm::dvec2 principal = from.principal_in_raster();
    view.low = -principal / from.focal_px;
    view.high = (glm::dvec2(from.width, from.height) - principal) / from.focal_px;
    view.tolerance = threshold_px / from.focal_px;
    return view;
}

void check(const View& view) {
    for (const glm::dvec3& v : {view.eye, view.right, view.down, view.forward})
        if (!is_finite(v)) throw core::Error("view: a value is not finite");
    if (glm::any(glm::greaterThan(glm::abs(view.eye), glm::dvec3(1e150))))
        throw core::Error("view: the eye is beyond 1e150");
    const glm::dmat3 axes(view.right, view.down, view.forward);
    const glm::dmat3 off = glm::transpose(axes) * axes - glm::dmat3(1);
    for (int i = 0; i < 3; ++i)
        if (glm::any(glm::greaterThan(glm::abs(off[i]), glm::dvec3(1e-6))))
            throw core::Error("view: the axes are not orthonormal");
    for (int i = 0; i < 2; ++i)
        if (!(view.low[i] < view.high[i] && view.low[i] >= -1e6 && view.high[i] <= 1e6))
            throw core::Error("view: the tangents of its sides are not in order, from -1e6 to 1e6");
    if (!(std::isfinite(view.tolerance) && view.tolerance >= 0))
        throw core::Error("view: the tolerance is not a number from 0 on");
}

RefinementTest::RefinementTest(const View& view, const Placement& placement, Culling culling)
    : eye_(placement.unit_from_world(view.eye)), tolerance_(view.tolerance), culling_(culling) {
    const auto side = [&](const glm::dvec3& across, double tangent, double sign) {
        return sign * (across - tangent * view.forward) / std::sqrt(1 + tangent * tangent);
    };
    inward_[0] = side(view.right, view.low.x, 1);
    inward_[1] = side(view.right, view.high.x, -1);
    inward_[2] = side(view.down, view.low.y, 1);
    inward_[3] = side(view.down, view.high.y, -1);
}

Verdict RefinementTest::operator()(const NodeBounds& node) const {
    const glm::dvec3 offset = node.centre - eye_;
    const double radius = decode_radius(node.radius), distance = std::sqrt(glm::dot(offset, offset));
    // Each written so that what is not a number refines.
    if (decode_error(node.error) <= tolerance_ * (distance - radius)) return Verdict::accurate;
    if (culling_ == Culling::off) return Verdict::refine;
    for (const glm::dvec3& inward : inward_)
        if (glm::dot(inward, offset) < -radius) return Verdict::outside;
    if (node.cone.angle < kAnyDirection &&
        is_turned_away(decode_cone(node.cone.axis, node.cone.angle), offset, distance, radius))
        return Verdict::faces_away;
    return Verdict::refine;
}

double RefinementTest::screen_error(const NodeBounds& node) const {
    const glm::dvec3 offset = node.centre - eye_;
    const double near = std::sqrt(glm::dot(offset, offset)) - decode_radius(node.radius);
    return near > 0 ? decode_error(node.error) / near : std::numeric_limits<double>::infinity();
}

}  // namespace pm
