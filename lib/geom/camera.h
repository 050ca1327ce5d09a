// Cameras, the view they make on a raster, and camera paths.
//
// View space: origin at the eye, x to the right, y DOWN, z forward (depth, positive before the
// eye), world units.  A point projects to pixel coordinates
//     px = width/2  + focal_px * x / z,     py = height/2 + focal_px * y / z;
// pixel (i, j) is the unit square from (i, j), its centre at (i + 0.5, j + 0.5), row 0 on top.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace geom {

// One frame of a path, world units.  `fovy_deg`: the vertical field of view, in (0, 180).
struct Camera {
    glm::dvec3 eye{0, 0, 1};
    glm::dvec3 target{0, 0, 0};
    glm::dvec3 up{0, 1, 0};
    double fovy_deg = 30;
    double time_s = 0;
    std::optional<double> near, far;  // depths; derived from the scene where absent
};

// A camera on a raster of width x height pixels.
struct View {
    int width = 0, height = 0;
    double focal_px = 0;
    glm::dvec3 eye{0};
    glm::dvec3 right{1, 0, 0}, down{0, 1, 0}, forward{0, 0, 1};  // orthonormal, world space
    std::optional<double> near, far;

    glm::dvec3 view_from_world(const glm::dvec3& p) const {
        const glm::dvec3 d = p - eye;
        return {glm::dot(right, d), glm::dot(down, d), glm::dot(forward, d)};
    }
};

// Throws core::Error, saying what to do, where eye equals target (within rounding), a value is not
// finite, or fovy_deg is not in (0, 180).  Where up is parallel to the line of sight (or zero)
// another axis is taken: the one least aligned with it.  Holds for lengths from 1e-150 to 1e150.
View make_view(const Camera& camera, int width, int height);

// JSON Lines, one camera a line: {"eye":[x,y,z],"target":[x,y,z],"up":[x,y,z],"fovy":deg,"t":s},
// optional "near", "far"; "up", "fovy", "t" may be left out (0,1,0; 30; line number / 24).  Blank lines
// are skipped, unknown keys ignored.  Throws core::Error "<name>: line N: ...".
Camera parse_camera(std::string_view line, const std::string& where);
std::vector<Camera> parse_path(std::string_view text, const std::string& name);
std::string format_camera(const Camera& camera);  // one line with its newline; reads back bit for bit

}  // namespace geom
