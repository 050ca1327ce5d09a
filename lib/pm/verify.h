// Verifying a model: the proof that its file is whole and its hierarchy right.
#pragma once

#include <cstdint>

#include "pm/model.h"

namespace pm {

struct VerifyCounts {
    uint64_t vertices = 0, faces = 0, details = 0;
    uint64_t dependencies = 0;
};

// Beyond what opening a model has checked (ranges, parents and children, order by error), that
// - the content is what its hash says, and what fills sections up is 0;
// - faces: as many as the header says, corners of three different vertices, no directed edge twice when fully
// refined;
// - cuts: the corners of each face that a detail adds are a leaf below its new child, one below its kept
// child, and one
//   beside them, which is apart from them before that detail splits (the face oracle: of the three pairs of
//   corners that of the detail itself is split last); those of the base mesh are below three roots;
// - needs: every detail needs exactly the one that splits the lowest common ancestor of its cuts, or an
// ancestor does;
// - bounds: the sphere about a node holds the input's faces that touch a leaf below it and, with the cone,
// their
//   normals (of every node, against every leaf below it: its cost is the sum of their depths);
// - errors: none is larger than that of the parent or of what it needs;
// - depth, as the header says; welds: pairs of one position.
// What it cannot see is whether the model is like the mesh it was made from.
//
// Throws core::Error for the first fault, "<name>: detail 7: ...".
VerifyCounts verify(const Model& model);

}  // namespace pm
