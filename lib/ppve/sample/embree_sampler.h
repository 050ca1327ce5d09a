// Depth images by casting a ray a pixel, with Embree: the third witness beside rasteriser and OpenGL, and the
// form that other ray casters take.  Optional (-DQS_EMBREE=ON).
//
// Embree intersects in single precision, from the mesh's origin: depths are right within some 2^-20 of the
// distances in the scene, and an edge may be missed by as much.
#pragma once

#include <memory>

#include "mesh/mesh.h"
#include "ppve/sampler.h"

namespace ppve {

// Throws core::Error for a cloud, and in a build without Embree.
std::unique_ptr<Sampler> open_embree_sampler(mesh::Mesh mesh);

}  // namespace ppve
