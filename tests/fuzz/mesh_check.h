// What must hold of every mesh that a reader accepts, whatever the bytes were.
#pragma once

#include <cmath>

#include "mesh/mesh.h"
#include "require.h"

inline void check_invariants(const mesh::ReadResult& result) {
    const mesh::Mesh& mesh = result.mesh;
    const size_t count = mesh.positions.size();
    require(mesh.normals.empty() || mesh.normals.size() == count, "one normal a vertex");
    require(mesh.colours.empty() || mesh.colours.size() == count, "one colour a vertex");
    for (const glm::vec3& p : mesh.positions)
        require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    for (const glm::vec3& n : mesh.normals) {
        const float length = glm::length(n);
        require(length == 0 || std::abs(length - 1) < 1e-5f, "normals are of unit length or zero");
    }
    for (const glm::u32vec3& t : mesh.triangles) {
        require(t.x < count && t.y < count && t.z < count, "indices are in range");
        require(t.x != t.y && t.y != t.z && t.z != t.x, "no triangle names a vertex twice");
    }
    uint64_t vertices = count, triangles = mesh.triangles.size();
    for (const auto& [reason, dropped] : result.counts.vertices_dropped) vertices += dropped;
    for (const auto& [reason, dropped] : result.counts.triangles_dropped) triangles += dropped;
    require(vertices == result.counts.vertices_in, "vertices in = kept + dropped");
    require(triangles == result.counts.triangles_in, "triangles in = kept + dropped");
}
