// Opening the models that can be drawn.
#pragma once

#include <string>

#include "core/file.h"

namespace scene {

// The bytes of a .qs model, a file or "-".  One of the original QSplat program is made into such a model in
// memory, at the cost of qs-build.  Throws core::Error: cannot be read, is damaged.  What is neither is
// returned as it is, for splat::Model to refuse.
core::InputFile open_model_file(const std::string& path);

}  // namespace scene
