// render/shading.h for shaders.
#pragma once

#include <string>

#include "gl/objects.h"
#include "render/shading.h"

namespace gl {

// The head of every shader that shades: the version, SHADE as one of LIT, NORMAL, LEVEL and FLAT, the
// constants, and
//     uint shaded(vec3 normal, vec3 material)
// which is 0xffBBGGRR of a unit normal in view space and a material of 0 to 255.
std::string shading_source(render::Shade shade);

// Of a program made with it, which is in use.
void set_light(const Use& gl, GLuint program, const render::Light& light);

}  // namespace gl
