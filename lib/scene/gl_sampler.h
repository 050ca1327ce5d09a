// Depth images by OpenGL's rasteriser: for machines with a graphics processor.
//
// As gl::MeshPainter draws: a third of a pixel finer, and the middle taken; depths in single precision, so
// that the bound of depths is at best focal_px * 2^-22 pixels; nothing nearer to the eye than a millionth of
// the scene's extent; perspective only.
#pragma once

#include <memory>

#include "mesh/mesh.h"
#include "ppve/sampler.h"

namespace scene {

// `osmesa`: Mesa's software renderer, without EGL.  Throws core::Error where it cannot be had, or was left
// out of the build.
std::unique_ptr<ppve::Sampler> open_gl_sampler(mesh::Mesh mesh, bool osmesa);

}  // namespace scene
