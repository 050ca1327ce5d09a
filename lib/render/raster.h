// Ground truth: an exact triangle rasteriser with the splatter's sampling (pixel centres), shading
// and frame.
#pragma once

#include "geom/camera.h"
#include "mesh/mesh.h"
#include "render/frame.h"

namespace render {

// Draws `mesh` (which lives longer).  Normals: the mesh's own, else area-weighted vertex normals,
// interpolated perspective-correctly; both sides of a triangle are drawn.  Clips at the eye's plane.  Parallel, same
// frame for any number of threads.  A cloud draws nothing.
class MeshRaster {
  public:
    explicit MeshRaster(const mesh::Mesh& mesh);
    ~MeshRaster();
    void draw(const geom::View& view, Shade shade, glm::u8vec3 background, Frame& frame);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace render
