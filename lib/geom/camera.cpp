#include "geom/camera.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "core/error.h"

namespace geom {
namespace {

using Json = nlohmann::json;

// Beyond these the squares of lengths leave the range of double.
constexpr double kLongest = 1e150;
constexpr double kShortest = 1e-150;

double largest(const glm::dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Divided by its largest component first: squares of tiny and huge lengths would be lost.
glm::dvec3 unit(const glm::dvec3& v) {
    return glm::normalize(v / largest(v));
}

// The axis least aligned with a unit vector.
glm::dvec3 other_axis(const glm::dvec3& direction) {
    glm::dvec3 axis(0);
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(direction[i]) < std::abs(direction[least])) least = i;
    axis[least] = 1;
    return axis;
}

// Unit length and at a right angle to `forward`.
glm::dvec3 right_of(const glm::dvec3& forward, const glm::dvec3& up) {
    // Below this sine the direction of the cross product is mostly rounding.
    constexpr double kParallel = 1e-10;
    glm::dvec3 right(0);
    if (largest(up) > 0) right = glm::cross(forward, unit(up));
    if (!(glm::length(right) > kParallel)) right = glm::cross(forward, other_axis(forward));
    right = glm::normalize(right);
    // A short cross product is at a right angle to within eps / sine only; once more gives eps.
    return glm::normalize(right - glm::dot(right, forward) * forward);
}

void check_point(const glm::dvec3& p, const char* key) {
    if (!is_finite(p)) throw core::Error(core::text("\"%s\" is not finite", key));
    if (largest(p) > kLongest)
        throw core::Error(core::text("\"%s\" has a coordinate of %g, beyond %g", key, largest(p), kLongest));
}

void check_depth(const std::optional<double>& depth, const char* key) {
    if (depth && !(*depth > 0 && *depth <= kLongest))
        throw core::Error(
            core::text("\"%s\" is %g, expected a depth above 0 and up to %g", key, *depth, kLongest));
}

constexpr size_t kLongestLine = 65536;  // a camera takes some 300 bytes; the rest is room for foreign keys

constexpr std::array kKeys{"eye", "target", "up", "fovy", "t", "near", "far"};

Json parse_object(std::string_view line) {
    std::set<std::string> seen;
    const auto refuse_twice = [&](int depth, Json::parse_event_t event, Json& parsed) {
        if (event != Json::parse_event_t::key || depth != 1) return true;
        const auto& key = parsed.get_ref<const std::string&>();
        const bool ours = std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end();
        if (ours && !seen.insert(key).second)
            throw core::Error(core::text("\"%s\" is there twice", key.c_str()));
        return true;
    };
    Json object;
    try {
        object = Json::parse(line.begin(), line.end(), refuse_twice);
    } catch (const Json::parse_error& error) {
        throw core::Error(core::text("column %zu: not JSON", error.byte));
    } catch (const Json::out_of_range&) {
        throw core::Error("a number is beyond the range of double");
    }
    if (!object.is_object())
        throw core::Error(core::text("expected a JSON object, found %s", object.type_name()));
    return object;
}

double number_of(const Json& value, const char* key) {
    if (!value.is_number())
        throw core::Error(core::text("\"%s\": expected a number, found %s", key, value.type_name()));
    return value.get<double>();
}

void read(const Json& object, const char* key, double& value) {
    if (const auto found = object.find(key); found != object.end()) value = number_of(*found, key);
}

void read(const Json& object, const char* key, std::optional<double>& value) {
    if (const auto found = object.find(key); found != object.end()) value = number_of(*found, key);
}

void read(const Json& object, const char* key, glm::dvec3& value) {
    const auto found = object.find(key);
    if (found == object.end()) return;
    if (!found->is_array())
        throw core::Error(core::text("\"%s\": expected 3 numbers, found %s", key, found->type_name()));
    if (found->size() != 3)
        throw core::Error(core::text("\"%s\": expected 3 numbers, found %zu", key, found->size()));
    for (int i = 0; i < 3; ++i) value[i] = number_of((*found)[size_t(i)], key);
}

void require(const Json& object, const char* key) {
    if (!object.contains(key)) throw core::Error(core::text("\"%s\" is missing", key));
}

Camera read_camera(std::string_view line, double default_time_s) {
    if (line.size() > kLongestLine)
        throw core::Error(core::text("is %zu bytes long, at most %zu are read", line.size(), kLongestLine));
    const Json object = parse_object(line);
    require(object, "eye");
    require(object, "target");
    Camera camera;
    camera.time_s = default_time_s;
    read(object, "eye", camera.eye);
    read(object, "target", camera.target);
    read(object, "up", camera.up);
    read(object, "fovy", camera.fovy_deg);
    read(object, "t", camera.time_s);
    read(object, "near", camera.near);
    read(object, "far", camera.far);
    check(camera);
    return camera;
}

bool is_blank(std::string_view line) {
    return line.find_first_not_of(" \t\r") == line.npos;
}

void append(std::string& out, double value) {
    if (!std::isfinite(value)) throw core::Error("a camera that is not finite cannot be written");
    // "-0" is an integer to JSON readers, and integers have no -0.
    if (value == 0 && std::signbit(value)) {
        out += "-0.0";
        return;
    }
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    out.append(digits.data(), end);
}

void append(std::string& out, const glm::dvec3& v) {
    for (int i = 0; i < 3; ++i) {
        out += i == 0 ? '[' : ',';
        append(out, v[i]);
    }
    out += ']';
}

template <class T>
void append(std::string& out, const char* before, const T& value) {
    out += before;
    append(out, value);
}

}  // namespace

void check(const Camera& camera) {
    check_point(camera.eye, "eye");
    check_point(camera.target, "target");
    if (!is_finite(camera.up)) throw core::Error("\"up\" is not finite");
    if (!(camera.fovy_deg >= kMinFovyDeg && camera.fovy_deg < 180))
        throw core::Error(core::text("\"fovy\" is %g degrees, expected %g up to, not including, 180",
                                     camera.fovy_deg, kMinFovyDeg));
    if (!std::isfinite(camera.time_s)) throw core::Error("\"t\" is not finite");
    check_depth(camera.near, "near");
    check_depth(camera.far, "far");
    if (camera.near && camera.far && !(*camera.near < *camera.far))
        throw core::Error(core::text("\"near\" is %g, not before \"far\", %g", *camera.near, *camera.far));

    const double apart = largest(camera.target - camera.eye);
    const double rounding =
        4 * std::numeric_limits<double>::epsilon() * std::max(largest(camera.eye), largest(camera.target));
    if (!(apart > rounding && apart >= kShortest))
        throw core::Error(
            core::text("\"eye\" and \"target\" are the same point (%.17g, %.17g, %.17g), so there is no "
                       "direction to look in; move one of them",
                       camera.eye.x, camera.eye.y, camera.eye.z));
}

View make_view(const Camera& camera, int width, int height) {
    check(camera);
    if (width < 1 || height < 1)
        throw core::Error(core::text("a raster of %d x %d has no pixels", width, height));
    View view;
    view.width = width;
    view.height = height;
    view.focal_px = 0.5 * height / std::tan(camera.fovy_deg * (std::numbers::pi / 360));
    view.eye = camera.eye;
    view.forward = unit(camera.target - camera.eye);
    view.right = right_of(view.forward, camera.up);
    view.down = glm::cross(view.forward, view.right);
    view.near = camera.near;
    view.far = camera.far;
    return view;
}

View part_of(const View& view, int left, int top, int width, int height) {
    View part = view;
    part.width = width, part.height = height;
    part.margins = {left, top, view.picture_width() - left - width, view.picture_height() - top - height};
    return part;
}

View moved_aside(const View& view, double offset, double depth) {
    View moved = view;
    moved.eye += offset * view.right;
    moved.shift_px.x += view.focal_px * (offset / depth);
    return moved;
}

View subdivided(const View& view, int across) {
    View fine = view;
    fine.width *= across, fine.height *= across;
    fine.focal_px *= across;
    fine.shift_px *= across;
    for (int* margin : {&fine.margins.left, &fine.margins.top, &fine.margins.right, &fine.margins.bottom})
        *margin *= across;
    return fine;
}

Camera parse_camera(std::string_view line, const std::string& where) {
    try {
        return read_camera(line, 0);
    } catch (const core::Error& error) {
        throw core::Error(where + ": " + error.what());
    }
}

std::vector<PathFrame> parse_frames(std::string_view text, const std::string& name) {
    std::vector<PathFrame> path;
    for (size_t begin = 0, number = 1; begin < text.size(); ++number) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        const std::string_view line = text.substr(begin, end - begin);
        begin = end + 1;
        if (is_blank(line)) continue;
        try {
            path.push_back({read_camera(line, double(path.size()) / kDefaultFps), ""});
        } catch (const core::Error& error) {
            path.push_back({{}, core::text("%s: line %zu: %s", name.c_str(), number, error.what())});
        }
    }
    if (path.empty()) throw core::Error(name + ": holds no camera");
    return path;
}

std::vector<Camera> parse_path(std::string_view text, const std::string& name) {
    std::vector<Camera> path;
    for (PathFrame& frame : parse_frames(text, name)) {
        if (!frame.fault.empty()) throw core::Error(frame.fault);
        path.push_back(frame.camera);
    }
    return path;
}

std::string format_camera(const Camera& camera) {
    std::string line;
    append(line, "{\"eye\":", camera.eye);
    append(line, ",\"target\":", camera.target);
    append(line, ",\"up\":", camera.up);
    append(line, ",\"fovy\":", camera.fovy_deg);
    append(line, ",\"t\":", camera.time_s);
    if (camera.near) append(line, ",\"near\":", *camera.near);
    if (camera.far) append(line, ",\"far\":", *camera.far);
    line += "}\n";
    return line;
}

std::string format_path(std::span<const Camera> path) {
    std::string text;
    for (const Camera& camera : path) text += format_camera(camera);
    return text;
}

}  // namespace geom
