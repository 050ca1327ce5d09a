#include "geom/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"

namespace geom {
namespace {

// How near a path goes that was not told how near: the eye stays outside the bounding sphere.
constexpr double kNearestRadii = 1.1;

constexpr double radians(double degrees) {
    return degrees * (std::numbers::pi / 180);
}

double largest(const glm::dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

glm::dvec3 unit(const glm::dvec3& v) {
    return glm::normalize(v / largest(v));
}

Sphere with_extent(Sphere sphere) {
    if (sphere.radius == 0) sphere.radius = 1;
    sphere.radius = std::max(sphere.radius, 1e-14 * largest(sphere.centre));
    return sphere;
}

// The model's directions, orthonormal; right = up x front.
struct Axes {
    glm::dvec3 up, front, right;
};

Axes axes_of(const glm::dvec3& model_up) {
    Axes axes;
    axes.up = unit(model_up);
    const bool z_up = std::abs(axes.up.z) > std::max(std::abs(axes.up.x), std::abs(axes.up.y));
    const glm::dvec3 front = z_up ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
    axes.front = glm::normalize(front - glm::dot(front, axes.up) * axes.up);
    axes.right = glm::cross(axes.up, axes.front);
    return axes;
}

// A camera at `distance` from `target`.  Its up leans with the elevation, so that it stays at a right
// angle to the line of sight and the picture does not flip at the poles.
Camera camera_from(const Axes& axes, const glm::dvec3& target, double azimuth_deg, double elevation_deg,
                   double distance, double fovy_deg) {
    const double azimuth = radians(azimuth_deg), elevation = radians(elevation_deg);
    const glm::dvec3 level = std::cos(azimuth) * axes.front + std::sin(azimuth) * axes.right;
    Camera camera;
    camera.eye = target + distance * (std::cos(elevation) * level + std::sin(elevation) * axes.up);
    camera.target = target;
    camera.up = std::cos(elevation) * axes.up - std::sin(elevation) * level;
    camera.fovy_deg = fovy_deg;
    return camera;
}

void check_frame(const Camera& camera, int frame) {
    try {
        check(camera);
    } catch (const core::Error& error) {
        throw core::Error(core::text("frame %d: %s", frame, error.what()));
    }
}

// Calls camera_at(frame) for each frame of the shot.
template <class CameraAt>
std::vector<Camera> film(int frames, double fps, const CameraAt& camera_at) {
    std::vector<Camera> path;
    path.reserve(size_t(std::max(frames, 0)));
    for (int i = 0; i < frames; ++i) {
        path.push_back(camera_at(i));
        path.back().time_s = i / fps;
        check_frame(path.back(), i);
    }
    return path;
}

// What is interpolated: eye, target, up (3 each), log focal length, log near, log far.
constexpr int kChannels = 12;
using Point = std::array<double, kChannels>;

double log_focal(double fovy_deg) {
    return -std::log(std::tan(radians(fovy_deg) / 2));
}
double fovy_of(double log_focal_length) {
    return 2 * std::atan(std::exp(-log_focal_length)) / radians(1);
}

// Zooms are even, and stay within 0..180 degrees, in the log of the focal length.
Point point_of(const Camera& camera) {
    const glm::dvec3 up = largest(camera.up) > 0 ? unit(camera.up) : glm::dvec3(0);
    Point p{};
    for (int i = 0; i < 3; ++i) {
        p[size_t(i)] = camera.eye[i];
        p[size_t(3 + i)] = camera.target[i];
        p[size_t(6 + i)] = up[i];
    }
    p[9] = log_focal(camera.fovy_deg);
    p[10] = std::log(camera.near.value_or(1));
    p[11] = std::log(camera.far.value_or(1));
    return p;
}

// The camera at `p`, between `key` and the next.  What stays as it is in the key is not sent through its
// logarithm and back, which would change the last digit.
Camera camera_of(const Point& p, const Camera& key) {
    const Point k = point_of(key);
    Camera camera;
    camera.eye = {p[0], p[1], p[2]};
    camera.target = {p[3], p[4], p[5]};
    camera.up = {p[6], p[7], p[8]};
    camera.fovy_deg = p[9] == k[9] ? key.fovy_deg : fovy_of(p[9]);
    if (key.near) camera.near = p[10] == k[10] ? *key.near : std::exp(p[10]);
    if (key.far) camera.far = p[11] == k[11] ? *key.far : std::exp(p[11]);
    return camera;
}

// How far apart two keys are, as a length: turning up and zooming count by the distance looked over.
double key_distance(const Camera& a, const Camera& b) {
    const Point p = point_of(a), q = point_of(b);
    const double range = std::max(largest(a.target - a.eye), largest(b.target - b.eye));
    double square = 0;
    for (size_t c = 0; c < 10; ++c) {
        const double d = (q[c] - p[c]) * (c < 6 ? 1 : range);
        square += d * d;
    }
    return std::sqrt(square);
}

// A curve through points at growing parameters, with a tangent at each; closed curves repeat their first
// point (and tangent) as their last.
struct Curve {
    std::vector<double> knots;
    std::vector<Point> points, tangents;
};

// Slope of channel c from point k to k + 1.
double slope(const Curve& curve, size_t k, size_t c) {
    return (curve.points[k + 1][c] - curve.points[k][c]) / (curve.knots[k + 1] - curve.knots[k]);
}

// The tangent of the parabola through three neighbours, as Catmull-Rom for uneven knots has it.
double tangent_between(double slope_before, double step_before, double slope_after, double step_after) {
    return (slope_before * step_after + slope_after * step_before) / (step_before + step_after);
}

void set_tangents(Curve& curve, bool closed) {
    const size_t last = curve.points.size() - 1;
    const auto step = [&](size_t k) { return curve.knots[k + 1] - curve.knots[k]; };
    curve.tangents.resize(last + 1);
    for (size_t c = 0; c < kChannels; ++c) {
        for (size_t k = 1; k < last; ++k)
            curve.tangents[k][c] =
                tangent_between(slope(curve, k - 1, c), step(k - 1), slope(curve, k, c), step(k));
        curve.tangents[0][c] = slope(curve, 0, c);
        curve.tangents[last][c] = slope(curve, last - 1, c);
        if (closed)
            curve.tangents[0][c] = curve.tangents[last][c] =
                tangent_between(slope(curve, last - 1, c), step(last - 1), slope(curve, 0, c), step(0));
    }
}

Curve curve_through(std::span<const Camera> keys, bool closed) {
    const size_t segments = keys.size() - (closed ? 0 : 1);
    std::vector<double> steps(segments);
    for (size_t k = 0; k < segments; ++k)
        steps[k] = std::sqrt(key_distance(keys[k], keys[(k + 1) % keys.size()]));
    const double longest = *std::max_element(steps.begin(), steps.end());
    // Equal keys in a row are a rest; their knots must still grow.
    const double shortest = longest > 0 ? 1e-6 * longest : 1;

    Curve curve;
    curve.knots.push_back(0);
    curve.points.push_back(point_of(keys[0]));
    for (size_t k = 0; k < segments; ++k) {
        curve.knots.push_back(curve.knots.back() + std::max(steps[k], shortest));
        curve.points.push_back(point_of(keys[(k + 1) % keys.size()]));
    }
    set_tangents(curve, closed);
    return curve;
}

// Cubic from value a (tangent ta) to b (tangent tb) over `step`, at fraction f.  Exactly a where nothing
// changes.
double hermite(double a, double ta, double b, double tb, double step, double f) {
    const double g = 1 - f;
    return a + (b - a) * (f * f * (3 - 2 * f)) + step * f * g * (ta * g - tb * f);
}

Point point_at(const Curve& curve, size_t k, double knot) {
    const double step = curve.knots[k + 1] - curve.knots[k];
    const double f = (knot - curve.knots[k]) / step;
    Point p;
    for (size_t c = 0; c < kChannels; ++c)
        p[c] = hermite(curve.points[k][c], curve.tangents[k][c], curve.points[k + 1][c],
                       curve.tangents[k + 1][c], step, f);
    return p;
}

// The speed along the knots at each key: the harmonic mean of the neighbouring speeds, weighted as
// Fritsch and Butland do, keeps the cubic monotone.
double speed_between(double before, double time_before, double after, double time_after) {
    const double w = 2 * time_after + time_before, v = time_after + 2 * time_before;
    return (w + v) / (w / before + v / after);
}

std::vector<double> speeds_of(const Curve& curve, const std::vector<double>& times, bool closed) {
    const size_t last = times.size() - 1;
    const auto time = [&](size_t k) { return times[k + 1] - times[k]; };
    const auto mean = [&](size_t k) { return (curve.knots[k + 1] - curve.knots[k]) / time(k); };
    std::vector<double> speeds(last + 1);
    for (size_t k = 1; k < last; ++k) speeds[k] = speed_between(mean(k - 1), time(k - 1), mean(k), time(k));
    speeds[0] = mean(0);
    speeds[last] = mean(last - 1);
    if (closed) speeds[0] = speeds[last] = speed_between(mean(last - 1), time(last - 1), mean(0), time(0));
    return speeds;
}

std::vector<double> key_times(std::span<const Camera> keys, const Spline& options) {
    std::vector<double> times(keys.size() + (options.closed ? 1 : 0));
    for (size_t k = 0; k < times.size(); ++k) {
        times[k] = options.timing == Spline::Timing::keys ? keys[k].time_s : double(k);
        if (k > 0 && !(times[k] > times[k - 1]))
            throw core::Error(core::text("key %zu: its time is %g s, not after %g s of the key before", k + 1,
                                         times[k], times[k - 1]));
    }
    return times;
}

void check_keys(std::span<const Camera> keys, const Spline& options) {
    if (options.closed && options.timing == Spline::Timing::keys)
        throw core::Error(
            "a closed path has no time for its way from the last key to the first; time it evenly");
    const size_t fewest = options.closed ? 3 : 2;
    if (keys.size() < fewest)
        throw core::Error(core::text("expected %zu key cameras or more, found %zu", fewest, keys.size()));
    for (size_t k = 1; k < keys.size(); ++k)
        if (keys[k].near.has_value() != keys[0].near.has_value() ||
            keys[k].far.has_value() != keys[0].far.has_value())
            throw core::Error(
                core::text("key %zu: \"near\" and \"far\" must be in all keys or in none", k + 1));
}

int frame_count(double span, const Spline& options) {
    if (options.timing == Spline::Timing::even && options.frames > 0) return options.frames;
    double count = std::floor(span * options.fps + 1e-9);
    if (!options.closed) ++count;
    if (!(count <= kMostFrames))
        throw core::Error(
            core::text("%g s at %g frames a second are more than %d frames", span, options.fps, kMostFrames));
    return std::max(1, int(count));
}

// The times of the frames, in the keys' unit.
std::vector<double> frame_times(const std::vector<double>& times, const Spline& options) {
    const double span = times.back() - times.front();
    const int count = frame_count(span, options);
    const int steps = std::max(1, options.closed ? count : count - 1);
    std::vector<double> result(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i)
        result[size_t(i)] =
            options.timing == Spline::Timing::keys ? times.front() + i / options.fps : span * i / steps;
    return result;
}

}  // namespace

double fit_distance(const Sphere& bounds, double fovy_deg, double aspect) {
    const double half = radians(fovy_deg) / 2;
    // A side plane of the frustum passes through the eye at half the field of view from the axis; the
    // sphere touches it at a right angle.
    return bounds.radius / std::sin(std::min(half, std::atan(std::tan(half) * aspect)));
}

std::vector<Camera> orbit(const Sphere& bounds, const Shot& shot, const Orbit& options) {
    const Sphere sphere = with_extent(bounds);
    const Axes axes = axes_of(shot.up);
    const double distance = options.distance * fit_distance(sphere, shot.fovy_deg, shot.aspect);
    return film(shot.frames, shot.fps, [&](int i) {
        const double azimuth_deg = options.azimuth_deg + 360 * options.turns * i / shot.frames;
        return camera_from(axes, sphere.centre, azimuth_deg, options.elevation_deg, distance, shot.fovy_deg);
    });
}

std::vector<Camera> dolly(const Sphere& bounds, const Shot& shot, const Dolly& options) {
    const Sphere sphere = with_extent(bounds);
    const Axes axes = axes_of(shot.up);
    const glm::dvec3 target = options.target.value_or(sphere.centre);
    const double fit = fit_distance(sphere, shot.fovy_deg, shot.aspect);
    const double far = options.far_factor * fit;
    const double near = options.near_factor ? *options.near_factor * fit : kNearestRadii * sphere.radius;
    if (!(near < far))
        throw core::Error(core::text("the nearest distance, %g, is not below the farthest, %g", near, far));
    const int there = shot.frames - shot.frames / 2;  // steps on the way in; the rest lead out
    return film(shot.frames, shot.fps, [&](int i) {
        const double way = i <= there ? double(i) / there : double(shot.frames - i) / (shot.frames - there);
        const double distance = far * std::pow(near / far, way);
        return camera_from(axes, target, options.azimuth_deg, options.elevation_deg, distance, shot.fovy_deg);
    });
}

std::vector<Camera> walk(const Sphere& bounds, const Shot& shot, const Walk& options) {
    constexpr double kDefaultDistance = 0.6;
    constexpr double kReach = 0.6;  // how far from the centre the target goes up and down, in radii
    if (options.laps < 1 || shot.frames % options.laps != 0)
        throw core::Error(
            core::text("%d frames cannot be parted into %d equal laps", shot.frames, options.laps));
    const Sphere sphere = with_extent(bounds);
    const Axes axes = axes_of(shot.up);
    const double fit = fit_distance(sphere, shot.fovy_deg, shot.aspect);
    const double distance = options.distance
                                ? *options.distance * fit
                                : std::max(kDefaultDistance * fit, kNearestRadii * sphere.radius);
    const int frames_a_lap = shot.frames / options.laps;
    return film(shot.frames, shot.fps, [&](int i) {
        const double lap = double(i % frames_a_lap) / frames_a_lap;
        const double height = std::cos(radians(360 * lap));  // 1 on top, -1 at the bottom
        const glm::dvec3 target = sphere.centre + height * kReach * sphere.radius * axes.up;
        return camera_from(axes, target, 360 * options.turns * lap, options.elevation_deg * height, distance,
                           shot.fovy_deg);
    });
}

std::vector<Camera> spline(std::span<const Camera> keys, const Spline& options) {
    check_keys(keys, options);
    const std::vector<double> times = key_times(keys, options);
    const std::vector<double> frames = frame_times(times, options);
    const Curve curve = curve_through(keys, options.closed);
    const std::vector<double> speeds = speeds_of(curve, times, options.closed);
    const double frame_step = frames.size() > 1 ? frames[1] - frames[0] : 1;

    std::vector<Camera> path;
    path.reserve(frames.size());
    size_t k = 0;  // the segment of the frame
    for (size_t i = 0; i < frames.size(); ++i) {
        const double time = frames[i];
        while (k + 2 < times.size() && time >= times[k + 1]) ++k;
        const auto meets = [&](size_t key) { return std::abs(time - times[key]) <= 1e-9 * frame_step; };
        if (meets(k)) {
            path.push_back(keys[k]);
        } else if (meets(k + 1)) {
            path.push_back(keys[(k + 1) % keys.size()]);
        } else {
            const double step = times[k + 1] - times[k];
            const double knot = hermite(curve.knots[k], speeds[k], curve.knots[k + 1], speeds[k + 1], step,
                                        (time - times[k]) / step);
            path.push_back(camera_of(point_at(curve, k, knot), keys[k]));
        }
        path.back().time_s = options.timing == Spline::Timing::keys ? time : double(i) / options.fps;
        check_frame(path.back(), int(i));
    }
    return path;
}

}  // namespace geom
