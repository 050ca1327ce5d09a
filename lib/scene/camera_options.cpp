#include "scene/camera_options.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/program.h"
#include "geom/framing.h"
#include "geom/path.h"

namespace scene {

using core::UsageError;

namespace {

constexpr double kMostDegrees = 179;
constexpr double kMargin = 1.02;        // the spheres of an outline leave some free themselves
constexpr double kLeastExtent = 1e-14;  // of the radius to the largest coordinate, as orbit() has it

}  // namespace

void CameraOptions::add_to(core::Program& program) {
    const double turn = 360, pole = 90;
    azimuth = program.add_number("--camera-azimuth-angle", azimuth_deg, -turn, turn, "degrees",
                                 "Side to look from: 0 the front, 90 the model's +X");
    elevation = program.add_number("--camera-elevation-angle", elevation_deg, -pole, pole, "degrees",
                                   "Height of the eye over the focal point");
    all = {program.add_numbers("--camera-position", position, "X,Y,Z",
                               "The eye (default: where the model fills the picture)"),
           program.add_numbers("--camera-focal-point", focal_point, "X,Y,Z",
                               "Point in the middle of the picture (default: the model's centre)"),
           program.add_numbers("--camera-view-up", view_up, "X,Y,Z", "What points up in the picture"),
           program.add_number("--camera-view-angle", view_angle_deg, 0.001, kMostDegrees, "degrees",
                              "Vertical field of view"),
           azimuth,
           elevation};
}

std::string CameraOptions::given() const {
    for (const CLI::Option* option : all)
        if (option->count() > 0) return option->get_name();
    return "";
}

bool CameraOptions::needs_outline() const {
    return std::isnan(position[0]) && std::isnan(focal_point[0]);
}

// From the azimuth and elevation.
geom::Camera CameraOptions::towards(const geom::Sphere& bounds, std::span<const geom::Sphere> outline,
                                    double aspect, const glm::dvec3& up) const {
    const geom::Shot shot{1, geom::kDefaultFps, view_angle_deg, aspect, up};
    const geom::Camera round = geom::orbit(bounds, shot, {1, azimuth_deg, elevation_deg}).front();
    const glm::dvec3 c = glm::abs(bounds.centre);
    // Smaller models are seen from as far as orbit() says, so that rounding does not shake the camera.
    const bool has_extent = bounds.radius > kLeastExtent * std::max({c.x, c.y, c.z});
    return has_extent && needs_outline() ? geom::framed(round, outline, aspect, kMargin) : round;
}

geom::Camera CameraOptions::camera(geom::Sphere bounds, std::span<const geom::Sphere> outline,
                                   double aspect) const {
    if (!std::isnan(focal_point[0])) bounds.centre = {focal_point[0], focal_point[1], focal_point[2]};
    const glm::dvec3 up{view_up[0], view_up[1], view_up[2]};
    if (up == glm::dvec3(0)) throw UsageError("--camera-view-up: 0,0,0 is no direction");
    if (std::isnan(position[0])) return towards(bounds, outline, aspect, up);
    for (const CLI::Option* angle : {azimuth, elevation})
        if (angle->count() > 0)
            throw UsageError(angle->get_name() + ": not with --camera-position, which says where the eye is");
    geom::Camera camera;
    camera.eye = {position[0], position[1], position[2]};
    camera.target = bounds.centre;
    camera.up = up;
    camera.fovy_deg = view_angle_deg;
    try {
        geom::check(camera);
    } catch (const core::Error& error) {
        throw UsageError(std::string("--camera-position: ") + error.what());
    }
    return camera;
}

}  // namespace scene
