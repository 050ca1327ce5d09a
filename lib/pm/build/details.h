// From collapses to the details of a file: the hierarchy, what needs what, bounds that go with it, the order
// by error.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/bounds.h"
#include "pm/build/simplify.h"
#include "pm/model.h"

namespace pm {

// The sections of a file (format.h), by final numbers.
struct Details {
    uint32_t base_vertices = 0;
    std::vector<uint32_t> vertex;  // by number: which it was when the mesh was simplified
    std::vector<glm::u32vec3> base_faces;
    std::vector<uint32_t> root_split, kept, parent, needs;
    std::vector<Children> children;
    std::vector<SplitFaces> faces;
    std::vector<ConeCodes> cones;
    std::vector<uint8_t> error, radius;
    uint32_t depth = 0;

    uint32_t count() const { return uint32_t(kept.size()); }
    Hierarchy hierarchy() const { return {base_vertices, base_faces, kept, parent, needs, faces}; }
};

// `faces` are the input's, as given to simplify(); what it returned is consumed.  With `is_open` no cone is
// kept.
//
// The fundamental cut of a face that vanishes is the input's corner in its third place: a half-edge collapse
// moves the corners of faces and never makes a new one.
//
// A detail needs the split of the lowest common ancestor of its two cuts: before that both are one vertex,
// and its two faces would be one.  Sphere, cone and error of what is needed are grown over what needs it, and
// over its ancestors up to the first common one, so that the view's test of one implies, but for rare cases,
// that of the other. Then every error is capped by those that it depends on: it is stored no larger than
// where refinement stops before.
Details make_details(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
                     SimplifyResult&& simplified, bool is_open);

// The detail that splits the lowest common ancestor of the leaves of two vertices, or kNone if they are of
// different trees.  `a` and `b` differ.  Costs the depth.
uint32_t split_apart(const Hierarchy& hierarchy, uint32_t a, uint32_t b);

// Whether a detail is split whenever `below` is, by parents alone.
bool is_ancestor(const Hierarchy& hierarchy, uint32_t detail, uint32_t below);

}  // namespace pm
