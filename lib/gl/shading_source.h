// render/shading.h for shaders.
#pragma once

#include <string>

#include "render/frame.h"

namespace gl {

// The head of every shader that shades: the version, SHADE as one of LIT, NORMAL, LEVEL and FLAT, the
// constants, and
//     uint shaded(vec3 normal, vec3 material)
// which is 0xffBBGGRR of a unit normal in view space and a material of 0 to 255.
std::string shading_source(render::Shade shade);

}  // namespace gl
