// Wavefront OBJ: v (with colours), vn and f, in all forms of f; groups, materials and curves are passed over.
//
// Our own, because OpenMesh's reader drops faces with an index out of range and vertices that are
// not finite without a word, and doubles vertices at non-manifold edges.
#pragma once

#include "mesh/reader.h"

namespace mesh {

// Normals are kept where no vertex has two; colours where every vertex has one.
// Throws Error "file: line N: ...".
ReadResult read_obj(const Source& source, const ReadOptions& options);

// True if `keyword` may begin a line of an OBJ file.
bool is_obj_keyword(std::string_view keyword);

}  // namespace mesh
