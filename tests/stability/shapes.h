// Meshes and clouds that are hard to carry: generated, in double precision, always the same.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace stability {

// Without triangles: a cloud.
struct Shape {
    std::vector<glm::dvec3> vertices;
    std::vector<glm::u32vec3> triangles;
};

enum class Precision { single, twice };

// A closed surface about 0, of radius 0.8 to 1.2, with bumps down to a tenth of that; 2,402 vertices,
// 4,800 triangles, facing outwards.
Shape bumpy_sphere();

Shape tetrahedron();

// A flat strip of `count` triangles along x, 1 long, `aspect` times longer than it is wide.
Shape slivers(int count, double aspect);

// A closed surface whose vertices are 2^-k from the origin, k from 0 to `octaves`.
Shape halving_spacing(int octaves);

// Rolling ground, `size` wide, about 0 in x and z; 4,225 vertices, 8,192 triangles.
Shape terrain(double size);

// Each vertex as scale * v + offset, rounded to double.
Shape placed(Shape shape, double scale, const glm::dvec3& offset);

// As a file of this precision holds it.
double rounded(double value, Precision precision);

// `a` with the vertices and triangles of `b` after its own.
Shape joined(Shape a, const Shape& b);

// As a binary little-endian PLY.  Coordinates that are not finite are written as they are.
std::string to_ply(const Shape& shape, Precision precision);

}  // namespace stability
