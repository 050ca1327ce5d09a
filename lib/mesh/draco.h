// Draco meshes and point clouds (.drc).
#pragma once

#include "mesh/reader.h"

namespace mesh {

// Throws Error where the decoder refuses the bytes.
ReadResult read_draco(const Source& source, const ReadOptions& options);

}  // namespace mesh
