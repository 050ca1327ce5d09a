// Drawing the frames of a path from a progressive mesh.
#pragma once

#include "qs-render/arguments.h"

namespace qs_render {

// True where the sources are a progressive mesh, in a file or at a server.  Throws core::UsageError where
// they are one and something else, or one with a transform.
bool are_progressive(const std::vector<Source>& sources);

// Throws core::UsageError for options that mean nothing for triangles.
void draw_progressive(const Arguments& arguments, const std::string& source);

}  // namespace qs_render
