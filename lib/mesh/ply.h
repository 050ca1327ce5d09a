// Stanford PLY: ascii and both byte orders, properties in any order and of any type, faces or
// strips before or after the vertices, other elements anywhere.
//
// Binary vertices without lists and binary triangles are read by plain parallel loops; all else
// goes record by record.
#pragma once

#include "mesh/reader.h"

namespace mesh {

// Throws Error for all that the header promises and the body does not hold.
ReadResult read_ply(const Source& source, const ReadOptions& options);

}  // namespace mesh
