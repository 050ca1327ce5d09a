// Cameras, the view they make on a raster, and camera paths.
//
// View space: origin at the eye, x to the right, y DOWN, z forward (depth, positive before the
// eye), world units.  A point projects to coordinates in the picture
//     px = principal().x + focal_px * x / z,     py = principal().y + focal_px * y / z;
// pixel (i, j) is the unit square from (i, j), its centre at (i + 0.5, j + 0.5), row 0 on top.
// What is drawn, the raster, is the whole picture or a rectangle of it.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace geom {

constexpr double kDefaultFps = 24;    // frames a second where a path says nothing about time
constexpr double kMinFovyDeg = 1e-9;  // a pixel is then some roundings of a direction wide

// One frame of a path, world units.  `fovy_deg`: the vertical field of view, in [kMinFovyDeg, 180).
struct Camera {
    glm::dvec3 eye{0, 0, 1};
    glm::dvec3 target{0, 0, 0};
    glm::dvec3 up{0, 1, 0};
    double fovy_deg = 30;
    double time_s = 0;
    std::optional<double> near{}, far{};  // depths between which something is drawn; absent: no limit
};

// Pixels of a picture to the left of, above, to the right of and below a raster that is a part of it.
struct Margins {
    int left = 0, top = 0, right = 0, bottom = 0;
};

// A camera on a raster of width x height pixels.
//
// Whoever draws a view counts pixels in the picture and not in the raster, and decides nothing else by where
// the raster ends: then the pixels of a part are those of the whole, bit for bit.
struct View {
    int width = 0, height = 0;
    double focal_px = 0;
    glm::dvec3 eye{0};
    glm::dvec3 right{1, 0, 0}, down{0, 1, 0}, forward{0, 0, 1};  // orthonormal, world space
    std::optional<double> near{}, far{};                         // as in Camera
    Margins margins{};
    glm::dvec2 shift_px{0};  // of the line of sight from the middle of the picture: a frustum off its axis

    int picture_width() const { return margins.left + width + margins.right; }
    int picture_height() const { return margins.top + height + margins.bottom; }
    // Where the line of sight meets the picture.
    glm::dvec2 principal() const {
        return {0.5 * picture_width() + shift_px.x, 0.5 * picture_height() + shift_px.y};
    }
    // The same in the raster, from its first pixel's corner.
    glm::dvec2 principal_in_raster() const {
        return {principal().x - margins.left, principal().y - margins.top};
    }

    glm::dvec3 view_from_world(const glm::dvec3& p) const {
        const glm::dvec3 d = p - eye;
        return {glm::dot(right, d), glm::dot(down, d), glm::dot(forward, d)};
    }
};

// Throws core::Error, saying what is wrong, where a camera cannot be drawn: eye equals target
// (within 4 units of rounding, or nearer than 1e-150), a value is not finite, a coordinate is beyond
// 1e150, fovy_deg is out of range, or the depths are not 0 < near < far.
void check(const Camera& camera);

// Throws as check() does, and where width or height is below 1.  Where up is parallel to the line of
// sight (or zero) another axis is taken: the one least aligned with it.  Holds for lengths from 1e-150
// to 1e150: right, down and forward are orthonormal within 1e-15.
View make_view(const Camera& camera, int width, int height);

// The view of `width` x `height` pixels of another's picture, the first of which is (left, top).  The
// rectangle lies in the picture.
View part_of(const View& view, int left, int top, int width, int height);

// The view of an eye that is moved by `offset` to the right (world units) and looks the same way, its frustum
// shifted so that what is at `depth` before it stays where it was in the picture: one of a pair of eyes whose
// screen is at that depth.
View moved_aside(const View& view, double offset, double depth);

// The same picture with each pixel cut into across x across.
View subdivided(const View& view, int across);

// Paths as text, the format of camera-path(5): JSON Lines, one camera a line,
//     {"eye":[x,y,z],"target":[x,y,z],"up":[x,y,z],"fovy":degrees,"t":seconds}
// with optional "near" and "far".  "up", "fovy" and "t" may be left out (0,1,0; 30; the number of
// cameras before this one / 24, in parse_camera 0).  Blank lines are skipped, unknown keys ignored.
// Every camera returned has passed check().  A line longer than 65536 bytes is refused, and so is a
// path without a camera.  Throws core::Error "<name>: line N: ..." or "<where>: ...".
Camera parse_camera(std::string_view line, const std::string& where);
std::vector<Camera> parse_path(std::string_view text, const std::string& name);

// The same for those who go on after a line that is wrong: it is a frame that cannot be drawn.
struct PathFrame {
    Camera camera{};
    std::string fault{};  // "<name>: line N: ..."; empty: the camera has passed check()
};
std::vector<PathFrame> parse_frames(std::string_view text, const std::string& name);

// One line with its newline; reads back bit for bit.  Throws core::Error where a value is not finite.
std::string format_camera(const Camera& camera);
std::string format_path(std::span<const Camera> path);

}  // namespace geom
