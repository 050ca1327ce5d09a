#include "view/camera_moves.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace view {

namespace {

constexpr double kLeastFovyDeg = 1, kMostFovyDeg = 150;

// The move is made only where its result can be drawn.
geom::Camera if_drawable(const geom::Camera& before, const geom::Camera& after) {
    try {
        geom::check(after);
        return after;
    } catch (const core::Error&) {
        return before;
    }
}

// By Rodrigues' formula.
glm::dvec3 rotated(const glm::dvec3& v, const glm::dvec3& axis, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return c * v + s * glm::cross(axis, v) + (1 - c) * glm::dot(axis, v) * axis;
}

}  // namespace

geom::Camera turned(const geom::Camera& camera, const glm::dvec3& axis, double angle) {
    // The raster does not matter to the axes.
    const geom::View view = geom::make_view(camera, 1, 1);
    const glm::dvec3 in_world = axis.x * view.right + axis.y * view.down + axis.z * view.forward;
    geom::Camera after = camera;
    const glm::dvec3 back = camera.eye - camera.target;
    const double distance = glm::length(back);
    glm::dvec3 turned_back = rotated(-view.forward, in_world, angle);
    // Thousands of turns keep their distance.
    turned_back = glm::normalize(turned_back);
    after.eye = camera.target + distance * turned_back;
    after.up = rotated(-view.down, in_world, angle);
    return if_drawable(camera, after);
}

geom::Camera moved(const geom::Camera& camera, const glm::dvec3& way) {
    geom::Camera after = camera;
    after.eye += way;
    after.target += way;
    return if_drawable(camera, after);
}

geom::Camera approached(const geom::Camera& camera, const glm::dvec3& point, double factor, double nearest) {
    const double distance = glm::length(camera.eye - point);
    if (!(distance > 0) || (factor < 1 && distance * factor < nearest)) return camera;
    geom::Camera after = camera;
    after.eye = point + factor * (camera.eye - point);
    after.target = point + factor * (camera.target - point);
    return if_drawable(camera, after);
}

geom::Camera widened(const geom::Camera& camera, double factor) {
    constexpr double kRadians = std::numbers::pi / 180;
    geom::Camera after = camera;
    const double half = std::atan(factor * std::tan(0.5 * camera.fovy_deg * kRadians));
    // A camera that came from outside of these bounds may only come nearer to them.
    after.fovy_deg = std::clamp(2 * half / kRadians, std::min(camera.fovy_deg, kLeastFovyDeg),
                                std::max(camera.fovy_deg, kMostFovyDeg));
    return if_drawable(camera, after);
}

geom::Camera aimed(const geom::Camera& camera, const glm::dvec3& point) {
    geom::Camera after = camera;
    after.target = point;
    return if_drawable(camera, after);
}

glm::dvec3 point_at(const geom::View& view, double px, double py, double depth) {
    const glm::dvec2 p = view.principal_in_raster();
    const double x = depth * (px - p.x) / view.focal_px, y = depth * (py - p.y) / view.focal_px;
    return view.eye + x * view.right + y * view.down + depth * view.forward;
}

}  // namespace view
