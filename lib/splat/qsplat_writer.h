// Models for the original QSplat program, file version 11 (mesh/qsplat.h has the layout).
//
// Up to four children a node, by two cuts at the middle of the longest side of the leaves' box.  A leaf's
// radius is the largest of the smallest circles about its faces, so that the discs of a face's three corners
// cover it (QSplat, section 3.1).  Spheres are coded in closed loop: every decoded sphere holds all its
// leaves.
#pragma once

#include <cstdint>
#include <string>

#include "core/file.h"
#include "mesh/mesh.h"

namespace splat {

struct QsplatReport {
    uint64_t leaves = 0, nodes = 0, levels = 0, file_bytes = 0;
    uint64_t unreferenced = 0;  // vertices that belong to no face
    double leaf_inflation_mean = 0,
           leaf_inflation_max = 0;  // decoded by needed radius, where that is above 0
};

// Writes the model to `out` (not committed).  `mesh` is consumed.  `name` is for messages.  Throws
// core::Error where the format ends: fewer than three leaves (its reader needs three levels), 2^31 bytes and
// more, a size or place that single precision cannot tell apart.
QsplatReport write_qsplat(mesh::Mesh&& mesh, const std::string& name, core::OutputFile& out);

}  // namespace splat
