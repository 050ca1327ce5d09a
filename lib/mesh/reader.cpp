#include "mesh/reader.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace mesh {

namespace {

bool is_finite(const glm::dvec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool is_usable(const glm::dvec3& p) {
    // Written so that NaN is not usable.
    return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
           std::abs(p.z) <= kLargestCoordinate;
}

bool names_a_vertex_twice(const glm::u32vec3& t) {
    return t.x == t.y || t.y == t.z || t.z == t.x;
}

// Keeps the entries of `values` (empty, or one a vertex) whose new index is not kDropped.
constexpr uint32_t kDropped = ~uint32_t{0};

template <class T>
void keep_vertices(const std::vector<uint32_t>& new_index, std::vector<T>& values) {
    if (values.empty()) return;
    size_t kept = 0;
    for (size_t v = 0; v < values.size(); ++v)
        if (new_index[v] != kDropped) values[kept++] = values[v];
    values.resize(kept);
}

}  // namespace

std::string quoted(std::string_view word) {
    constexpr size_t kLongest = 40;
    std::string out = "'";
    for (const char c : word.substr(0, kLongest)) out += c >= ' ' && c <= '~' ? c : '?';
    return out + (word.size() > kLongest ? "...'" : "'");
}

Faces::Faces(const Source& source, uint64_t vertex_count, ReadResult& result)
    : source_(source), vertex_count_(vertex_count), result_(result) {
    // The largest index marks dropped vertices.
    if (vertex_count >= kDropped)
        throw core::Error(core::text("%s: %llu vertices, at most %u can be read", source.name.c_str(),
                                     static_cast<unsigned long long>(vertex_count), kDropped - 1));
}

void Faces::polygon(std::span<const int64_t> corners) {
    check(corners);
    ++result_.counts.faces_in;
    if (corners.size() < 3) {
        ++result_.counts.triangles_in;
        ++result_.counts.triangles_dropped["fewer_than_three_corners"];
        return;
    }
    for (size_t i = 2; i < corners.size(); ++i) add(corners[0], corners[i - 1], corners[i]);
}

void Faces::strips(std::span<const int64_t> corners) {
    size_t begin = 0;
    for (size_t i = 0; i <= corners.size(); ++i) {
        if (i < corners.size() && corners[i] != -1) continue;
        if (i > begin) strip(corners.subspan(begin, i - begin));
        begin = i + 1;
    }
}

void Faces::strip(std::span<const int64_t> corners) {
    if (corners.size() < 3) return polygon(corners);
    check(corners);
    ++result_.counts.faces_in;
    for (size_t i = 2; i < corners.size(); ++i) {
        const bool is_odd = i % 2 != 0;
        add(corners[i - (is_odd ? 1 : 2)], corners[i - (is_odd ? 2 : 1)], corners[i]);
    }
}

void Faces::check(std::span<const int64_t> corners) const {
    for (const int64_t index : corners)
        if (index < 0 || static_cast<uint64_t>(index) >= vertex_count_)
            throw core::Error(
                core::text("%s: face %llu uses vertex %lld, file has %llu vertices", source_.name.c_str(),
                           static_cast<unsigned long long>(result_.counts.faces_in),
                           static_cast<long long>(index), static_cast<unsigned long long>(vertex_count_)));
}

void Faces::add(int64_t a, int64_t b, int64_t c) {
    ++result_.counts.triangles_in;
    if (a == b || b == c || c == a) {
        ++result_.counts.triangles_dropped["repeated_index"];
        return;
    }
    result_.mesh.triangles.emplace_back(static_cast<uint32_t>(a), static_cast<uint32_t>(b),
                                        static_cast<uint32_t>(c));
}

void drop_repeated(ReadResult& result) {
    const size_t dropped = std::erase_if(result.mesh.triangles, names_a_vertex_twice);
    if (dropped != 0) result.counts.triangles_dropped["repeated_index"] += dropped;
}

glm::dvec3 origin_among(uint64_t count, const std::function<glm::dvec3(uint64_t)>& point_at) {
    constexpr uint64_t kMostSamples = 4095;
    const uint64_t samples = std::min(count, kMostSamples);
    std::array<std::vector<double>, 3> axes;
    for (uint64_t i = 0; i < samples; ++i) {
        const glm::dvec3 point = point_at(i * count / samples);
        if (!is_usable(point)) continue;
        for (int k = 0; k < 3; ++k) axes[size_t(k)].push_back(point[k]);
    }
    if (axes[0].empty()) return glm::dvec3(0);
    const auto median = [](std::vector<double>& values) {
        const auto middle = values.begin() + ptrdiff_t(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    };
    return {median(axes[0]), median(axes[1]), median(axes[2])};
}

glm::vec3 relative_to(const glm::dvec3& origin, const glm::dvec3& point) {
    if (is_usable(point)) return glm::vec3(point - origin);
    return glm::vec3(is_finite(point) ? std::numeric_limits<float>::infinity()
                                      : std::numeric_limits<float>::quiet_NaN());
}

float to_single(double value) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    if (value > kLargest) return std::numeric_limits<float>::infinity();
    if (value < -kLargest) return -std::numeric_limits<float>::infinity();
    return static_cast<float>(value);
}

void place_points(std::span<const glm::dvec3> points, Mesh& mesh) {
    mesh.origin = origin_among(points.size(), [&](uint64_t i) { return points[i]; });
    mesh.positions.reserve(points.size());
    for (const glm::dvec3& p : points) mesh.positions.push_back(relative_to(mesh.origin, p));
}

glm::vec3 unit_normal(const glm::dvec3& normal) {
    // Scaled first: the squares of 1e-200 and 1e200 are 0 and infinity.
    const double largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
    if (!(largest > 0) || !is_finite(normal)) return glm::vec3(0);
    const glm::dvec3 scaled = normal / largest;
    return glm::vec3(scaled / std::sqrt(glm::dot(scaled, scaled)));
}

uint8_t colour_from_fraction(double fraction) {
    if (!(fraction > 0)) return 0;
    return static_cast<uint8_t>(std::lround(std::min(fraction, 1.0) * 255));
}

void settle_bad_vertices(const Source& source, const ReadOptions& options, bool is_placed,
                         ReadResult& result) {
    Mesh& mesh = result.mesh;
    const auto bad = [](const glm::vec3& p) { return !is_finite(glm::dvec3(p)); };
    const auto first = std::find_if(mesh.positions.begin(), mesh.positions.end(), bad);
    if (first == mesh.positions.end()) return;
    if (!options.skip_bad) {
        const bool is_too_large = is_placed && std::isinf(first->x);
        throw core::Error(
            core::text("%s: vertex %td: coordinate is %s (qs-build and pm-build drop it with --skip-bad)",
                       source.name.c_str(), first - mesh.positions.begin(),
                       is_too_large ? "too large for single precision" : "not finite"));
    }
    std::vector<uint32_t> new_index(mesh.positions.size());
    uint32_t kept = 0;
    for (size_t v = 0; v < new_index.size(); ++v) new_index[v] = bad(mesh.positions[v]) ? kDropped : kept++;
    result.counts.vertices_dropped["not_finite"] += new_index.size() - kept;
    keep_vertices(new_index, mesh.positions);
    keep_vertices(new_index, mesh.normals);
    keep_vertices(new_index, mesh.colours);
    keep_vertices(new_index, mesh.radii);

    for (glm::u32vec3& t : mesh.triangles) t = {new_index[t.x], new_index[t.y], new_index[t.z]};
    const size_t lost = std::erase_if(mesh.triangles, [](const glm::u32vec3& t) {
        return t.x == kDropped || t.y == kDropped || t.z == kDropped;
    });
    if (lost != 0) result.counts.triangles_dropped["not_finite_vertex"] += lost;
}

}  // namespace mesh
