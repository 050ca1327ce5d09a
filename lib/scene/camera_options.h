// The camera of a single frame, as the command line gives it.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/program_fwd.h"
#include "geom/camera.h"
#include "geom/sphere.h"

namespace scene {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

struct CameraOptions {
    std::array<double, 3> position{kNotGiven, kNotGiven, kNotGiven};
    std::array<double, 3> focal_point{kNotGiven, kNotGiven, kNotGiven};
    std::array<double, 3> view_up{0, 1, 0};
    double view_angle_deg = 30, azimuth_deg = 0, elevation_deg = 15;
    std::vector<CLI::Option*> all;
    CLI::Option *azimuth = nullptr, *elevation = nullptr;

    void add_to(core::Program& program);

    // Names the first of the options that was given, if any was.
    std::string given() const;

    // Neither the eye nor the focal point was given.
    bool needs_outline() const;

    // bounds: of the model.  outline: spheres that hold it more tightly, to fill the picture where they are
    // needed.  aspect: width / height of the picture.  Throws core::UsageError where the options contradict
    // each other or the camera looks nowhere.
    geom::Camera camera(geom::Sphere bounds, std::span<const geom::Sphere> outline, double aspect) const;

  private:
    geom::Camera towards(const geom::Sphere& bounds, std::span<const geom::Sphere> outline, double aspect,
                         const glm::dvec3& up) const;
};

}  // namespace scene
