// Opening the models that can be drawn.
#pragma once

#include <string>

#include "core/file.h"

namespace scene {

// The bytes of a .qs model, a file or "-".  One of the original QSplat program, or a mesh (told by its name:
// .ply, .obj, .off, .stl, .drc), is made into such a model in memory, at the cost of qs-build; a mesh's
// leaves are its triangles.  Throws core::Error: cannot be read, is damaged.  What is neither is returned as
// it is, for splat::Model to refuse.
core::InputFile open_model_file(const std::string& path);

}  // namespace scene
