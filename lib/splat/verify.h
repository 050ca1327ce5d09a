// Verifying a model: the proof that a file is whole.
#pragma once

#include <cstdint>

#include "core/file.h"

namespace splat {

struct VerifyCounts {
    uint64_t blocks = 0, nodes = 0, leaves = 0;
    uint32_t levels = 0;
    uint64_t triangles = 0;  // of them, with triangle leaves, as many as leaves
};

// Checks that
// - header: checksum, ranges, no unknown flag, no flags that exclude each other, nothing in its reserved
// bytes;
// - the file has exactly the bytes that the header says;
// - of a compressed model: container, tables, every page of the index, and that every block decodes;
// - every block: checksum, counts, zeros in what it does not use, its pointer to its first child group;
// - every sibling group is reached exactly once, and stands where breadth-first order puts it;
// - every node: codes in the range that builders use, a radius above 0, a culling sphere inside its
//   parent's, as decoded, and a normal cone that meets that of the nearest node above which has one: both
//   bound the normals of the faces below the node, so they have directions in common;
// - where leaves are triangles: every run is reached exactly once and stands where the order puts it, corners
// are on
//   the lattice and in their tables, codes of normals in their range, and each triangle lies in its leaf's
//   ellipsoid;
// - nodes, leaves, levels and blocks are as many as the header says.
// What it cannot see is whether the model is like the mesh it was made from.
//
// Throws core::Error for the first fault "<name>: block 7 at byte 8192: ...", and for a file that is cut
// off, after what is there was found without fault.
VerifyCounts verify(core::InputFile file);

}  // namespace splat
