// STL, binary and ascii: a soup of triangles whose equal corners become one vertex.
//
// Our own, because OpenMesh's reader takes a binary file that begins with "solid" for text.
#pragma once

#include "mesh/reader.h"

namespace mesh {

// True if the size is what the triangle count of a binary STL says.
bool is_binary_stl(const Source& source);

// Corners are vertices_in; those that fell together are dropped as "welded".  Normals of facets
// are passed over.  Throws Error "file: line N: ..." or "file: ...".
ReadResult read_stl(const Source& source, const ReadOptions& options);

}  // namespace mesh
