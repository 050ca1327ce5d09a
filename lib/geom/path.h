// Generated camera paths: pure functions from a bounding sphere (world units) to the cameras of all
// frames.  The same arguments give the same cameras.
//
// Directions are given by azimuth and elevation about the model's `up`.  Azimuth 0 looks at the front
// and grows to the model's right (counter-clockwise from above); the front is +Z, or -Y where up is
// along Z, so that +X is to the right for up = +Y and for up = +Z.
//
// Distances are factors of the fit distance, at which the sphere just touches the frame.  A sphere
// without extent is seen as one of radius 1, and none is seen smaller than 1e-14 of its centre's
// largest coordinate: nearer by, rounding would shake the camera by more than a hundredth of the picture.
//
// All throw core::Error where a camera would not pass geom::check() (values that are not finite, an
// eye that would reach its target, coordinates beyond 1e150).  Messages count frames from 0, as the
// pictures' names do, and keys from 1, as lines.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geom/camera.h"
#include "geom/sphere.h"

namespace geom {

constexpr int kMostFrames = 1'000'000;  // some 11 hours; more is a slip of the keyboard

// What all generated paths have in common.
struct Shot {
    int frames = 240;          // 1..kMostFrames
    double fps = kDefaultFps;  // > 0; frame i has time_s = i / fps
    double fovy_deg = 30;
    double aspect = 16.0 / 9;  // width / height of the picture, > 0
    glm::dvec3 up{0, 1, 0};    // of the model; any length but 0
};

// Smallest distance from eye to centre at which the whole sphere is in the frame: what counts is the
// narrower of the two fields of view.
double fit_distance(const Sphere& bounds, double fovy_deg, double aspect);

// Round the centre at one elevation.  With whole turns the frame after the last is the first.
struct Orbit {
    double turns = 1;           // negative: clockwise from above
    double azimuth_deg = 0;     // of the first frame
    double elevation_deg = 15;  // -90..90
    double distance = 1.05;     // a margin of 5 %
};
std::vector<Camera> orbit(const Sphere& bounds, const Shot& shot, const Orbit& options = {});

// From far to near and back, by the same factor of distance from each frame to the next.  The frame
// after the last is the first; the nearest is reached exactly (with 2 frames or more).
struct Dolly {
    std::optional<glm::dvec3> target{};  // absent: the centre
    double azimuth_deg = 0;
    double elevation_deg = 15;
    double far_factor = 4;
    std::optional<double> near_factor{};  // < far_factor; absent: 1.1 radii from the target
};
std::vector<Camera> dolly(const Sphere& bounds, const Shot& shot, const Dolly& options = {});

// A close look round the model from top to bottom and, on other sides, up again; then the same again,
// bit for bit but for the time: what a client was sent in the first lap must do for the second.
//
// Kim, Lee, Kobbelt.  View-dependent streaming of progressive meshes, section 8: there "the client looks
// around the model from top to bottom twice".  The way back up is ours, so that the view never jumps.
struct Walk {
    int laps = 2;                      // frames must be a multiple
    int turns = 2;                     // in each lap, half of them on the way down
    std::optional<double> distance{};  // absent: 0.6, but not below 1.1 radii
    double elevation_deg = 30;         // at the top; at the bottom it is the negative
};
std::vector<Camera> walk(const Sphere& bounds, const Shot& shot, const Walk& options = {});

// A smooth path through the key cameras, which it meets exactly.
//
// The curve is a centripetal Catmull-Rom spline through eye, target, direction of up, log of the focal
// length and log of the depths; it has neither cusps nor loops between keys (Yuksel, Schaefer, Keyser,
// Parameterization and applications of Catmull-Rom curves, 2011).  Along it the camera moves by a
// monotone cubic in time (Fritsch, Carlson 1980), so that its speed has no jump at a key.
struct Spline {
    enum class Timing {
        even,  // the same time from each key to the next
        keys,  // at the keys' own times, which must grow from key to key; one frame each 1 / fps
    };
    Timing timing = Timing::even;
    int frames = 0;  // timing even only, at most kMostFrames; 0: one second from each key to the next, at fps
    double fps = kDefaultFps;
    bool closed = false;  // timing even only: go back from the last key to the first
};
// `keys` have passed check(); at least 2, 3 for a closed path.  An open path ends at the last key, a
// closed one a frame before the first.  "near" and "far" are in all keys or in none.  A key is met by a
// frame where its time is a frame's (within 1e-9 of a frame), and is then copied bit for bit.
std::vector<Camera> spline(std::span<const Camera> keys, const Spline& options = {});

}  // namespace geom
