// Surfaces to be sampled, from whatever file they are in.
#pragma once

#include <span>
#include <string>

#include "mesh/mesh.h"

namespace scene {

// What the files hold, as one mesh, or as one cloud whose points have radii and normals: all that qs-build
// reads, and .qs models, whose leaves count.  "-" is standard input.  Triangles and points in one are
// refused.  Of several files the first one's origin is that of all.  Throws core::Error.
mesh::Mesh read_surfaces(std::span<const std::string> paths);

}  // namespace scene
