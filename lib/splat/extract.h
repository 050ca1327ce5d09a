// Taking a level out of a model, as points or triangles.
#pragma once

#include <cstdint>

#include "core/file.h"
#include "splat/model.h"

namespace splat {

// Writes the cut at `level` (0 is the root's splat) to `out` (not committed): the nodes of the level, the
// leaves above it, and of a prefix the nodes above it whose children are not there.  Together they stand for
// the whole surface.  A binary little-endian PLY of points, in the order of the file, in world units: x y z,
// nx ny nz, radius (across), flatness (half thickness / radius), error, and red green blue where the model
// has colour.  Coordinates are double where single precision would be coarser than 1e-6 of the model's
// radius.
//
// Where leaves are triangles, the last level is a mesh: a binary little-endian PLY of vertices, x y z, those
// that share a place on the lattice made one, and faces, vertex_indices and red green blue where the model
// has colour.
//
// Throws core::Error: no such level, a damaged block, triangles that are not there.
struct CutWritten {
    uint64_t points = 0, triangles = 0;  // one of them
};
CutWritten write_cut(const Model& model, uint32_t level, core::OutputFile& out);

}  // namespace splat
