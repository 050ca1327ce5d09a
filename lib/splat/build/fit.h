// Fitting a group of children, a lane a child: normal, cone, centre and radius are coded against the decoded
// parent so that each child's ellipsoid, as decoded, holds its points.
//
// Results do not depend on the vector length: lanes do not meet but in minima and maxima of separately
// rounded values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "splat/build/arrays.h"
#include "splat/node.h"

namespace splat {

constexpr size_t kLanes = 8;  // children of a group, and one spare

template <class T>
using Lanes = std::array<T, kLanes>;

// The children of one parent.
struct GroupContent {
    size_t count = 0;
    Lanes<glm::vec3> normal;  // wanted, unit
    Lanes<bool> is_leaf;
    // What each child must hold, relative to the parent's centre: row k holds each child's point k, kLanes in
    // all. Children with fewer points repeat one.
    size_t rows = 0;
    std::vector<float> x, y, z;  // room for as many rows as any group had
    Lanes<size_t> points{};      // of each child, without repetitions; at least one
    // Vectors that the cone must hold: [begin, end) for each child; none: no cone.
    const PointArrays* face_normals = nullptr;
    Lanes<size_t> face_begin{}, face_end{};

    void set_rows(size_t n) {
        rows = n;
        if (x.size() < n * kLanes) x.resize(n * kLanes), y.resize(n * kLanes), z.resize(n * kLanes);
    }
    void set_point(size_t row, size_t child, const glm::vec3& p) {
        x[row * kLanes + child] = p.x, y[row * kLanes + child] = p.y, z[row * kLanes + child] = p.z;
    }
};

struct GroupFit {
    Lanes<uint16_t> attitude{}, place{};  // attitude without children count and error
    Lanes<uint8_t> shape{};               // without error
    Lanes<glm::vec3> offset, normal;      // as decoded; the offset from the parent's centre, times its radius
    Lanes<float> inflation{};             // decoded radius / radius of the sphere about the points' middle
    // The code is much too large for the points, and a smaller one is in reach under a smaller parent: the
    // node should stand between, with the content as its one child.
    Lanes<bool> is_between{};
};

// `content` is used up: its points are turned in place.
void fit_group(GroupContent& content, const Node& parent, GroupFit& fit);

// Child k of a fitted group as decode_node() gives it; without error and children count.
Node node_of(const GroupFit& fit, size_t k, uint16_t colour, const Node& parent);

// Least and greatest coordinates along u, v, w, (u+v) and (u-v).
struct Extent {
    float low[5], high[5];
};
// Of points [begin, end), turned into `frame`.
Extent extent_of(const PointArrays& points, size_t begin, size_t end, const Frame& frame);

}  // namespace splat
