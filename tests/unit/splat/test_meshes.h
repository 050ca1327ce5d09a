// Meshes for the tests of models, the models built from them, and model files in memory.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "model_bytes.h"
#include "splat/build.h"
#include "splat/model.h"

namespace splat_test {

// Uniform in [0, 1), the same with every library.
class Random {
  public:
    explicit Random(uint64_t seed) : engine_(seed) {}
    uint64_t bits() { return engine_(); }
    double unit() { return double(engine_() >> 11) * 0x1p-53; }
    glm::dvec3 direction();  // uniform on the unit sphere

  private:
    std::mt19937_64 engine_;
};

mesh::Mesh tetrahedron();
mesh::Mesh two_triangles();
mesh::Mesh icosphere(int subdivisions);
mesh::Mesh bumpy_torus(int around, int along, bool has_colours = false);
mesh::Mesh terrain(int side);         // open, rough
mesh::Mesh needle_fan(int needles);   // open, slivers of aspect 1e4 about one vertex
mesh::Mesh with_duplicates();         // every face twice, vertices twice, faces without area
mesh::Mesh soup(int triangles);       // random ones, through each other
mesh::Mesh moebius_strip(int along);  // no sense of its faces fits all
mesh::Mesh mixed_scales();            // a small ball on wide terrain, and far from it
mesh::Mesh cloud(int points);
mesh::Mesh scaled(mesh::Mesh mesh, double by);
mesh::Mesh shifted(mesh::Mesh mesh, const glm::dvec3& by);

struct NamedMesh {
    std::string name;
    mesh::Mesh mesh;
};
std::vector<NamedMesh> generated_meshes();

// A real model, or an empty mesh where it is not there.
mesh::Mesh shared_mesh(const std::string& file);

Bytes build_bytes(mesh::Mesh mesh, const splat::BuildOptions& options = {},
                  splat::BuildReport* report = nullptr);

// The same model, compressed.
Bytes compressed(const Bytes& plain);
inline splat::Model open_model(const Bytes& bytes) {
    return splat::Model(memory_file(bytes));
}
splat::Model build_model(mesh::Mesh mesh, const splat::BuildOptions& options = {});

Bytes read_bytes(const std::string& path);

// All nodes, breadth-first; [0] is the root.
struct Tree {
    std::vector<splat::Node> nodes;
    std::vector<uint32_t> first_child, parent, level;
};
Tree read_tree(const splat::Model& model);

// In model units: is `p` inside the drawn ellipsoid, which may be larger by `tolerance` of its radius?
bool is_inside(const splat::Node& node, const glm::dvec3& p, double tolerance);

}  // namespace splat_test
