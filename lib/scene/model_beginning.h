// The beginning of a model at a web server, for programs that want to know what it is, and not to draw it.
#pragma once

#include <string>

#include "core/file.h"

namespace scene {

// What a first picture needs, fetched through qs-fetch's cache in the folder `cache` (empty: its default): a
// prefix of the model, which is a coarser model.  Throws core::Error where it cannot be had, and where it is
// no splat model.
core::InputFile open_beginning(const std::string& url, const std::string& cache);

}  // namespace scene
