// Triangles and splats of meshes in view space, for the tests of what draws both.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "render/backend.h"

namespace render_test {

struct Triangle {
    glm::vec3 corners[3];
    glm::vec3 normals[3];
    uint32_t colour = 0x00808080;
};

struct Disc {
    glm::vec3 centre;
    float radius;
    glm::vec3 normal;
    float flatness;
    uint32_t colour = 0x00808080;
};

struct Scene {
    std::vector<Triangle> triangles;
    std::vector<Disc> discs;
};

geom::View view_of(int width, int height, double focal_px);

// Begins a frame and adds an equal share of the triangles and of the discs to each task; batches have
// `batch_size` items.
void add(render::SplatPainter& painter, const geom::View& view, const render::SplatterOptions& options,
         const Scene& scene, size_t task_count = 3, int batch_size = 512);
// The same, and finishes it.
render::Frame draw(render::SplatPainter& painter, const geom::View& view,
                   const render::SplatterOptions& options, const Scene& scene, size_t task_count = 3,
                   int batch_size = 512);
render::Frame draw(const geom::View& view, const render::SplatterOptions& options, const Scene& scene,
                   size_t task_count = 3, int batch_size = 512);

// As a batch has it: positions are view space, normals the mesh's, or those of its vertices.
std::vector<Triangle> triangles_of(const mesh::Mesh& mesh);
// The flat disc that holds a triangle, and hardly more.
Disc disc_of(const Triangle& triangle);

// `mesh` as `view` sees it: its triangles where `is_splat` is false for their middle in view space, else
// discs.
template <class IsSplat>
Scene hybrid_of(const mesh::Mesh& mesh, const IsSplat& is_splat) {
    Scene scene;
    for (const Triangle& t : triangles_of(mesh)) {
        if (is_splat((t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f))
            scene.discs.push_back(disc_of(t));
        else
            scene.triangles.push_back(t);
    }
    return scene;
}

// The mesh in view space: what a camera at `eye` with the view's axes sees, rounded to float.
mesh::Mesh seen_from(mesh::Mesh mesh, const glm::dvec3& eye, const glm::dvec3& forward);

// Subdivided `levels` times; all vertices at distance 1 from the middle.
mesh::Mesh icosphere(int levels);
// The same, of that radius about `middle`, with its normals.
mesh::Mesh ball(int levels, const glm::vec3& middle, float radius);

// A rectangle of cells x cells squares at depth z, cut into triangles at random, inner vertices moved by up
// to `jitter` cells within it and by `roughness` in depth; from (x0, y0), `step` wide.
mesh::Mesh sheet(int cells, float x0, float y0, float step, float z, float jitter, float roughness,
                 uint32_t seed);

size_t covered(const render::Frame& frame);

// Pixels that but one of them covers, of those the largest relative difference of depths, and how many differ
// by more than `levels` in a channel.
struct Difference {
    size_t covered_apart = 0, turned = 0;
    double depth = 0;
};
Difference difference(const render::Frame& a, const render::Frame& b, int levels = 1);

}  // namespace render_test
