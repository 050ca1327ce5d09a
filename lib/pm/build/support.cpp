#include "pm/build/support.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/parallel.h"
#include "pm/format.h"

namespace pm {

namespace {

constexpr double kPi = std::numbers::pi, kHalfPi = 0.5 * kPi;

double squared_length(const glm::dvec3& v) {
    return glm::dot(v, v);
}

double share(double part, double whole) {
    return whole > 0 ? part / whole : 0;
}

// Ericson, Real-Time Collision Detection, 5.1.5: by the region of the triangle's plane that the point is
// over.  A triangle without area is the segment or the point that it is.
double squared_distance_to_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                    const glm::dvec3& c) {
    const glm::dvec3 ab = b - a, ac = c - a, ap = p - a;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return squared_length(ap);
    const glm::dvec3 bp = p - b;
    const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return squared_length(bp);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return squared_length(ap - share(d1, d1 - d3) * ab);
    const glm::dvec3 cp = p - c;
    const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return squared_length(cp);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return squared_length(ap - share(d2, d2 - d6) * ac);
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6)
        return squared_length(bp - share(d4 - d3, (d4 - d3) + (d5 - d6)) * (c - b));
    const double area = va + vb + vc;
    return squared_length(ap - share(vb, area) * ab - share(vc, area) * ac);
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// More than single precision rounds an axis and an angle by.
constexpr double kRounding = 1e-6;

NormalCone cone_about(const glm::dvec3& axis, double half_angle) {
    if (!(half_angle < kHalfPi)) return {glm::vec3(0, 0, 1), NormalCone::kWide};
    return {glm::vec3(axis), float(half_angle + kRounding)};
}

// Of the normals of a leaf's own faces.  A face without area is never seen and has none.
NormalCone cone_of(std::span<const Spoke> ring, const glm::dvec3& at, std::span<const glm::dvec3> positions) {
    const auto normal_of = [&](const Spoke& s) {
        return glm::cross(positions[s.next] - at, positions[s.previous] - at);
    };
    glm::dvec3 sum{0};
    bool is_empty = true;
    for (const Spoke& s : ring) {
        const glm::dvec3 normal = normal_of(s);
        const double length = glm::length(normal);
        if (length > 0) sum += normal / length, is_empty = false;
    }
    if (is_empty) return {};
    const double length = glm::length(sum);
    if (!(length > 0)) return cone_about({}, kPi);
    double half_angle = 0;
    for (const Spoke& s : ring)
        if (const glm::dvec3 normal = normal_of(s); normal != glm::dvec3(0))
            half_angle = std::max(half_angle, angle_between(sum / length, normal));
    return cone_about(sum / length, half_angle);
}

}  // namespace

NormalCone merged(const NormalCone& a, const NormalCone& b) {
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    if (!a.is_useful() || !b.is_useful()) return cone_about({}, kPi);
    const glm::dvec3 from(a.axis), to(b.axis);
    const double first = double(a.half_angle), second = double(b.half_angle),
                 between = angle_between(from, to);
    if (between + second <= first) return a;
    if (between + first <= second) return b;
    // On the arc from one axis to the other.  These are not opposite, or the cone is too wide.
    const double turn = 0.5 * (between + second - first);
    const glm::dvec3 across = to - from * glm::dot(from, to);
    const double length = glm::length(across);
    const glm::dvec3 axis =
        length > 0 ? glm::normalize(std::cos(turn) * from + (std::sin(turn) / length) * across) : from;
    return cone_about(axis, 0.5 * (first + between + second));
}

Supports::Supports(std::span<const glm::dvec3> positions, size_t face_count, const Rings& rings)
    : positions_(positions),
      next_leaf_(positions.size(), kNone),
      last_leaf_(positions.size()),
      leaf_radius_(positions.size()),
      cones_(positions.size()),
      leaves_(positions.size(), 1),
      error_(positions.size()),
      worst_leaf_(positions.size()),
      nearest_face_(positions.size()),
      changed_(face_count),
      measured_(positions.size()) {
    core::parallel_for(
        positions.size(),
        [&](size_t i) {
            const auto v = uint32_t(i);
            last_leaf_[v] = worst_leaf_[v] = v;
            nearest_face_[v] = rings[v][0].corner / 3;
            double radius2 = 0;
            for (const Spoke& s : rings[v])
                radius2 = std::max({radius2, squared_length(positions[s.next] - positions[v]),
                                    squared_length(positions[s.previous] - positions[v])});
            leaf_radius_[v] =
                std::nextafter(float(std::sqrt(radius2)), std::numeric_limits<float>::infinity());
            cones_[v] = cone_of(rings[v], positions[v], positions);
        },
        1024);
}

void Supports::begin_pass() {
    if (pass_ == std::numeric_limits<uint16_t>::max()) {
        // As if all had changed: every leaf is looked at once more.
        std::fill(changed_.begin(), changed_.end(), uint16_t(1));
        std::fill(measured_.begin(), measured_.end(), uint16_t(0));
        pass_ = 1;
    }
    ++pass_;
}

void Supports::join(uint32_t removed, uint32_t kept) {
    next_leaf_[last_leaf_[kept]] = removed;
    last_leaf_[kept] = last_leaf_[removed];
    cones_[kept] = merged(cones_[kept], cones_[removed]);
    leaves_[kept] += leaves_[removed];
    if (error_[removed] > error_[kept]) worst_leaf_[kept] = worst_leaf_[removed];
}

Support Supports::measure(uint32_t kept, std::span<const glm::u32vec3> corners, const Rings& rings) {
    double radius = 0;
    for (uint32_t leaf = kept; leaf != kNone; leaf = next_leaf_[leaf])
        radius =
            std::max(radius, glm::length(positions_[leaf] - positions_[kept]) + double(leaf_radius_[leaf]));
    error_[kept] = 0, measured_[kept] = 0;
    return {radius * (1 + 1e-12), error_[kept] = worst_error(kept, corners, rings), cones_[kept], 0};
}

double Supports::worst_error(uint32_t vertex, std::span<const glm::u32vec3> corners, const Rings& rings) {
    const double known2 = error_[vertex] * error_[vertex];
    double worst2 = known2;
    // Once a leaf asks for them: the vertex's own faces, and then those of its neighbours, since at the
    // border of what is below the vertex the nearest face may be theirs.
    struct Near {
        glm::dvec3 a, b, c;  // here, since many leaves come for them
        uint32_t face;
        double squared_distance(const glm::dvec3& p) const {
            return squared_distance_to_triangle(p, a, b, c);
        }
    };
    const auto near = [&](uint32_t f) {
        const glm::u32vec3& face = corners[f];
        return Near{positions_[face.x], positions_[face.y], positions_[face.z], f};
    };
    thread_local std::vector<Near> faces;
    faces.clear();
    const size_t own = rings[vertex].size();
    const auto add_own = [&] {
        for (const Spoke& s : rings[vertex]) faces.push_back(near(s.corner / 3));
    };
    const auto add_neighbours = [&] {
        for (const Spoke& spoke : rings[vertex])
            for (const Spoke& s : rings[spoke.next])
                if (s.next != vertex && s.previous != vertex) faces.push_back(near(s.corner / 3));
    };
    const auto is_there = [&](uint32_t face) {
        const glm::u32vec3& c = corners[face];
        return !rings[c.x].empty() && !rings[c.y].empty() && !rings[c.z].empty();
    };
    const uint16_t measured = std::exchange(measured_[vertex], pass_);
    const auto look_at = [&](uint32_t leaf) {
        uint32_t& nearest = nearest_face_[leaf];
        if (changed_[nearest] <= measured) return;
        const glm::dvec3 p = positions_[leaf];
        // Only the worst leaf counts: one face within the worst so far is enough to go on.
        if (squared_length(p - positions_[vertex]) <= worst2) return;
        double nearest2 = is_there(nearest) ? near(nearest).squared_distance(p) : INFINITY;
        if (nearest2 > worst2 && faces.empty()) add_own();
        for (size_t i = 0; i != faces.size() && nearest2 > worst2; ++i) {
            const double d2 = faces[i].squared_distance(p);
            if (d2 < nearest2) nearest2 = d2, nearest = faces[i].face;
            if (i + 1 == own && faces.size() == own && nearest2 > worst2) add_neighbours();
        }
        if (nearest2 > worst2) worst2 = nearest2, worst_leaf_[vertex] = leaf;
    };
    // The one that was worst is so again, more or less, and spares the others a search.
    look_at(worst_leaf_[vertex]);
    for (uint32_t leaf = vertex; leaf != kNone; leaf = next_leaf_[leaf]) look_at(leaf);
    return worst2 > known2 ? std::sqrt(worst2) : error_[vertex];
}

}  // namespace pm
