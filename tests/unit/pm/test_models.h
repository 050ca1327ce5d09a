// Progressive meshes in memory, and faces that can be compared.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "pm/build.h"
#include "pm/front.h"
#include "pm/model.h"
#include "test_meshes.h"

namespace pm_test {

using splat_test::Random;

// The bytes of a model, and the model.
Bytes build_bytes(const mesh::Mesh& mesh, const pm::BuildOptions& options = {});
pm::Model build_model(const mesh::Mesh& mesh, const pm::BuildOptions& options = {});

// With checksums that hold.
Bytes repaired(Bytes bytes);
std::string fault_of(const Bytes& bytes, const std::function<void(const pm::Model&)>& use);

pm::BuildOptions lossless();

// Faces by three numbers or places, turned so that the least comes first, and sorted: equal if the faces are
// the same with the same sense.
using Faces = std::vector<std::array<uint32_t, 3>>;
using PlacedFaces = std::vector<std::array<std::array<float, 3>, 3>>;
Faces sorted(const std::vector<glm::u32vec3>& faces);
PlacedFaces placed(const mesh::Mesh& mesh);

// A mesh without those faces that are there twice with one sense.
mesh::Mesh without_duplicates(mesh::Mesh mesh);

// Every shape that a builder must take, with its name.
struct NamedMesh {
    const char* name;
    mesh::Mesh mesh;
};
std::vector<NamedMesh> all_shapes();

mesh::Mesh one_triangle();
mesh::Mesh pierced_ball();
mesh::Mesh bow_tie();        // two tetrahedra with one vertex in common
mesh::Mesh book(int pages);  // triangles about one edge
mesh::Mesh strip(int triangles);
mesh::Mesh hub(int spokes);             // a flat disc of triangles about one vertex
mesh::Mesh two_sheets();                // four faces about an edge, joined at both of its ends
mesh::Mesh crossed_sheets(int across);  // two bumpy grids with a row of vertices in common

}  // namespace pm_test
