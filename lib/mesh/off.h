// Object File Format: OFF and its variants with colours (C), normals (N) and texture coordinates (ST).
//
// Our own, because OpenMesh's reader allocates what the counts claim, and turns the 5,021 vertices
// of a non-manifold model into 125,393.
#pragma once

#include "mesh/reader.h"

namespace mesh {

// Text or, where "BINARY" stands behind the keyword, binary as Geomview writes it.  Colours of faces are
// passed over.  Throws Error "file: line N: ...", of a binary file "file: face N: ...".
ReadResult read_off(const Source& source, const ReadOptions& options);

// True if `word` is the keyword an OFF file begins with, in any variant.
bool is_off_keyword(std::string_view word);

}  // namespace mesh
