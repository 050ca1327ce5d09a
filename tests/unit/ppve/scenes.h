// Small meshes and frusta for the tests of remote point sampling.
#pragma once

#include <cmath>
#include <random>

#include "geom/camera.h"
#include "mesh/mesh.h"
#include "ppve/depth_image.h"

namespace ppve_test {

inline double uniform(std::mt19937_64& random, double low, double high) {
    return low + (high - low) * double(random() >> 11) * 0x1p-53;
}

// A closed, coloured, bumpy ball of about 2 * rings^2 triangles, of the given radius about the mesh's origin.
inline mesh::Mesh ball(int rings, double radius, const glm::dvec3& origin = glm::dvec3(0)) {
    mesh::Mesh mesh;
    mesh.origin = origin;
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i <= rings; ++i) {
            const double polar = 3.14159265358979 * j / rings, around = 2 * 3.14159265358979 * i / rings;
            const double r = radius * (1 + 0.05 * std::sin(9 * polar) * std::cos(7 * around));
            const glm::dvec3 p = r * glm::dvec3(std::sin(polar) * std::cos(around), std::cos(polar),
                                                std::sin(polar) * std::sin(around));
            mesh.positions.push_back(glm::vec3(p));
            mesh.colours.push_back(
                {uint8_t(40 + 200 * i / rings), uint8_t(250 - 200 * j / rings), uint8_t(i * 37 + j * 11)});
        }
    for (uint32_t j = 0; j < uint32_t(rings); ++j)
        for (uint32_t i = 0; i < uint32_t(rings); ++i) {
            const uint32_t at = j * uint32_t(rings + 1) + i, below = at + uint32_t(rings + 1);
            mesh.triangles.push_back({at, at + 1, below});
            mesh.triangles.push_back({at + 1, below + 1, below});
        }
    return mesh;
}

// Triangles of all sizes and shapes about the origin, slivers and degenerate ones among them.
inline mesh::Mesh soup(size_t count, uint64_t seed) {
    std::mt19937_64 random(seed);
    mesh::Mesh mesh;
    for (size_t t = 0; t < count; ++t) {
        const glm::dvec3 at(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
        const double size = std::exp2(uniform(random, -12, 0));
        const uint32_t first = uint32_t(mesh.positions.size());
        for (int k = 0; k < 3; ++k) {
            glm::dvec3 p = at + size * glm::dvec3(uniform(random, -1, 1), uniform(random, -1, 1),
                                                  uniform(random, -1, 1));
            if (k == 2 && random() % 8 == 0) p = glm::dvec3(mesh.positions[first]) + 1e-6 * size;
            mesh.positions.push_back(glm::vec3(p));
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

inline ppve::Frustum looking_from(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                                  double fovy_deg = 40) {
    geom::Camera camera;
    camera.eye = eye, camera.target = target, camera.fovy_deg = fovy_deg;
    return {geom::make_view(camera, width, height)};
}

}  // namespace ppve_test
