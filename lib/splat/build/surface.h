// The surface about the leaves of a subtree, leaf by leaf: faces, shares, normals and colours.
//
// The share of a face that belongs to one of its corners is the part nearer to it than to the other two.
// Shares are convex, so an ellipsoid that holds the corners of a share holds the share; the shares of all
// leaves cover the surface.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/build/arrays.h"
#include "splat/build/tree.h"

namespace splat {

// One subtree of a mesh or cloud.  Model units.
struct SubtreeInput {
    uint32_t begin = 0, end = 0;        // leaves, in tree order
    std::span<const TreePoint> points;  // all of the model's
    std::span<const glm::u32vec3>
        faces;             // those that touch the subtree, and more about them, as leaf numbers
    glm::dvec3 offset{0};  // model = (position + offset) * inverse_scale
    double inverse_scale = 1;
    std::span<const glm::vec3> normals;    // by input vertex, or empty
    std::span<const glm::u8vec3> colours;  // by input vertex, or empty
    std::span<const float> cloud_radii;    // by input vertex, world units, for bare points

    glm::dvec3 model(uint32_t leaf) const {
        return (glm::dvec3(points[leaf].position) + offset) * inverse_scale;
    }
};

// Of leaves that are triangles: the faces about their corners.  Vertices are numbered from 0; those of the
// leaves come first.
struct TriangleFans {
    std::vector<glm::u32vec3> corners;  // by leaf: vertices
    std::vector<glm::dvec3> at;         // by vertex, relative to the surface's base
    std::vector<uint32_t> begin;        // by vertex of a leaf, and the end
    std::vector<glm::u32vec2> fan;      // the other two corners, in the face's sense
    PointArrays p, q;                   // where these are from the vertex; room for kSpare more
    std::vector<uint8_t> is_closed;     // by vertex of a leaf: do the faces that are known go round it?
    float rounding = 0;                 // no corner is further from the input's vertex
};

// Leaves are numbered from 0, in tree order.  What is relative to a leaf is precise however small its faces
// are beside the subtree.
struct Surface {
    uint32_t count = 0;
    glm::dvec3 base{0};  // the first leaf, model units
    // Corners of the faces, relative to base: the leaves, then the corners that are leaves of other subtrees.
    std::vector<glm::dvec3> at;
    std::vector<uint32_t> leaf;  // which leaf of the model each is
    // Faces about each corner, as far as they are known: the numbers of the other two corners p and q, in the
    // face's sense.  Behind the last face there is room for kSpare more.
    std::vector<uint32_t> fan_begin;  // by corner, and the end
    std::vector<glm::u32vec2> fan;
    std::vector<uint32_t> fan_side;  // by entry of the fan: the edge of its face that goes out to p
    std::vector<uint8_t> is_closed;  // by leaf: do the faces go round it?
    // What is looked at face by face, in one line of memory.
    static constexpr uint32_t kNone = ~0u;
    struct alignas(32) Face {
        glm::u32vec3 corner{0};  // numbers
        uint32_t mark = 0;       // for leaf_errors(): when the face was looked at last
        // For each edge the one of another face that runs against it, or kNone where there is none or more
        // than one.  Edge `side_of(f, k)` goes from corner k of face f to the next.
        uint32_t against[3] = {kNone, kNone, kNone};
    };
    std::vector<Face> faces;
    // What an ellipsoid must hold to cover the leaf's shares, relative to the leaf.  Those behind rim_end are
    // within the hull of what the leaf's siblings (the kMaxFanOut from a multiple of it on) have before
    // theirs: a face whose corners are all siblings needs no more than these.
    std::vector<uint32_t> corner_begin, rim_end;
    PointArrays corners;
    // Unit normals of the faces (and of the vertex, where it has one); at least one a leaf.
    std::vector<uint32_t> normal_begin;
    PointArrays face_normals;
    std::vector<glm::dvec3> normal;        // sums weighted by area
    std::vector<glm::u64vec3> colour_sum;  // of all leaves before

    static uint32_t side_of(uint32_t face, uint32_t k) { return 4 * face + k; }
    static uint32_t face_of(uint32_t side) { return side / 4; }
    // Where leaves are triangles: `at` is a corner of each, `fan` and what belongs to it is empty.
    TriangleFans triangles;

    bool has_triangles() const { return !triangles.corners.empty(); }
    uint32_t valence(uint32_t i) const { return fan_begin[i + 1] - fan_begin[i]; }
    static uint32_t first_sibling(uint32_t leaf) { return leaf - leaf % uint32_t(kMaxFanOut); }
};

Surface gather_surface(const SubtreeInput& input);

// `v` made a unit vector, or `otherwise` where it has no direction.
glm::vec3 unit_or(const glm::dvec3& v, const glm::vec3& otherwise);

}  // namespace splat
