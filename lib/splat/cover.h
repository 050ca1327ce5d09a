// The inner loops of the builder: fitting ellipsoids over points, in SIMD chosen at run time.
//
// Results do not depend on the vector length: only minima and maxima of separately rounded
// values leave these functions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/node.h"

namespace splat {

constexpr size_t kLanes = 8;

// Points, structure of arrays.  Whole vectors are loaded: after filling, spare() makes room behind the last.
struct PointArrays {
    std::vector<float> x, y, z;
    size_t size() const { return x.size(); }
    void clear() { x.clear(), y.clear(), z.clear(); }
    void push(const glm::vec3& p) { x.push_back(p.x), y.push_back(p.y), z.push_back(p.z); }
    void set(size_t i, const glm::vec3& p) { x[i] = p.x, y[i] = p.y, z[i] = p.z; }
    glm::vec3 get(size_t i) const { return {x[i], y[i], z[i]}; }
    void spare() { resize(size() + kLanes); }
    void resize(size_t n) { x.resize(n), y.resize(n), z.resize(n); }
};

// Least and greatest coordinates along u, v, w, (u+v) and (u-v).
struct Extent {
    float low[5], high[5];
};

// What must be covered, in a node's own frame: u, v across the normal, w along it, relative to the
// parent's centre.
struct FramePoints {
    std::vector<float> u, v, w;
    size_t count = 0;
};

// Rotates points [begin, end) minus `base` into `frame`, into `out`; returns their extent.
Extent rotate(const PointArrays& points, size_t begin, size_t end, const glm::vec3& base, const Frame& frame,
              FramePoints& out);

// A cell of the centre's lattice: two steps along each axis (in parts of the limit); `limit` in parts of the
// parent's radius `scale`.  Centre k takes the higher step of a, b, c by bits 0, 1, 2 of k.
struct LatticeCell {
    float a[2], b[2], c[2];
    float limit, scale;
    float allowed;    // squares above it are of no interest: they may come out too small, but still above
    glm::vec3 ideal;  // where the centre should be
};

// For each centre of the cell and each kFlatness: the largest (u - cu)^2 + (v - cv)^2 + ((w - cw) / rho)^2, the
// square of the radius across that covers all points.  False, and nothing computed, where the square of the
// distance of all centres from the ideal one is above `bound`.
struct Cover8 {
    float square[4][kLanes];
};
bool cover_lattice(const FramePoints& points, const LatticeCell& cell, float bound, Cover8& out);

// Largest square of a point's distance from `centre`.
float farthest_square(const FramePoints& points, const glm::vec3& centre);

// Least dot product of `normal` with the vectors [begin, end).
float least_dot(const PointArrays& vectors, size_t begin, size_t end, const glm::vec3& normal);

// The faces about a vertex, as the other two corners p and q of each: arrays of the same length, kLanes of spare
// at the end.
struct FanArrays {
    PointArrays p, q;
};

// How the faces [begin, end) about a vertex at `v` lie over the disc of `radius` about `centre`, across frame.n.
struct FanView {
    bool is_folded;     // a face is not seen from the normal's side
    float height;       // no face goes further up or down over the disc
    uint64_t crossing;  // bit k: the edge p-q of face begin + k comes within the radius (nearly: rather yes)
};
// At most 64 faces.
FanView view_fan(const FanArrays& fan, size_t begin, size_t end, const glm::vec3& v, const glm::vec3& centre, const Frame& frame,
                 float radius);

// Bound on the distance from any point of the disc to the faces [begin, end) about `v` (of more than 64, the first
// 64), found as nested_error() does.  Infinity without faces.
float fan_error(const FanArrays& fan, size_t begin, size_t end, const glm::vec3& v, const glm::vec3& centre, const Frame& frame,
                float radius);

// A child's disc in its parent's frame, for nested_error().
struct ChildShape {
    glm::vec3 centre;  // relative to the parent's centre, u v w
    glm::vec3 normal;
    float radius, error;
};

// Bound on the distance from any point of a disc (about 0, across w) to the surface, given discs that each
// stay within their `error` of it: the disc is cut into 48 convex cells, and the distance to a convex set is
// largest at a cell's corners.
float nested_error(float radius, std::span<const ChildShape> children);

}  // namespace splat
