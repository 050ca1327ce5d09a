// How far the points of a node's disc are from the surface, in SIMD chosen at run time; the same for any vector length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "splat/arrays.h"
#include "splat/node.h"

namespace splat {

// About some centre, across frame.n.
struct Disc {
    Frame frame;
    float radius;
};

// The faces [begin, end) about a vertex: p and q are their other two corners, relative to it.
struct Fan {
    const PointArrays *p, *q;
    size_t begin, end;
    glm::vec3 vertex;  // relative to the disc's centre
};

// How a fan of at most 64 faces lies over a disc.
struct FanView {
    bool is_folded;     // a face is not seen from the normal's side
    float height;       // no face goes further up or down over the disc
    uint64_t crossing;  // bit k: the edge p-q of face begin + k comes within the radius (nearly: rather yes)
};
FanView view_fan(const Fan& fan, const Disc& disc);

// Bound on the distance from any point of the disc to the faces (of more than 64, the first 64), found as
// nested_error() does.  Infinity without faces.
float fan_error(const Fan& fan, const Disc& disc);

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
