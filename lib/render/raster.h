// Ground truth: an exact triangle rasteriser with the splatter's sampling (pixel centres), shading
// and frame.
//
// A pixel is covered where the ray through its centre meets a triangle before the eye, decided by the exact
// sign of three determinants of the vertices in view space (double precision, each vertex rounded once).
// Nothing is snapped to a grid and nothing is clipped, so triangles may reach behind the eye and be of any
// size.  Two triangles at a common edge evaluate the same determinant, and a ray that meets an edge exactly
// counts as if the sample lay slightly further right and then down (the top-left rule): no cracks, nothing
// covered twice.
//
// Olano, Greer.  Triangle scan conversion using 2D homogeneous coordinates.  1997.
#pragma once

#include <memory>
#include <vector>

#include "mesh/mesh.h"
#include "render/backend.h"

namespace render {

// The normals that a mesh is drawn with, one a vertex: its own, and where they are unknown the area-weighted
// mean of the faces at the vertex; unit length, or zero where no face with an area is there.
std::vector<glm::vec3> filled_normals(const mesh::Mesh& mesh);

// Draws `mesh` (which lives longer).  Of surfaces at the same depth the one with the lower triangle index
// shows.
//
// Depths are view z, always finite where a pixel is covered; a depth beyond float is the largest float.
// Parallel; the same frame for any number of threads; one draw() at a time.
// Exact while the magnitudes of the coordinates (from the eye) differ by less than 1e60 in one scene.
// Memory: 40 bytes a vertex (52 where normals are computed) and 12 a triangle in view, kept between frames.
// Of several samples a pixel each is drawn as a pixel of a larger picture would be; the frame is their mean.
class MeshRaster final : public MeshPainter {
  public:
    explicit MeshRaster(const mesh::Mesh& mesh);
    ~MeshRaster() override;
    void draw(const geom::View& view, const Look& look, Frame& frame) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace render
