// Normals at corners of triangles: octahedral, 4095 x 4095, column and row << 12; what has no direction is
// code 0.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace splat {

constexpr int kCornerNormalSteps = 4095;
constexpr uint32_t kCornerNormalBits = 12;  // a column, or a row

// Of a vector of any length.
uint32_t encode_corner_normal(const glm::dvec3& n);
glm::vec3 decode_corner_normal(uint32_t code);  // unit length

// What normals triangles give their corners by themselves, as codes: from the sums of their faces' normals by
// area. Positions on the lattice, by axis and corner; codes.size() corners.  Files depend on the result to
// the bit (man/qs.5): single precision, in the order in which it is written.
void tell_corner_normals(std::span<const glm::u32vec3> triangles, const std::vector<int32_t> (&positions)[3],
                         std::span<uint32_t> codes);

}  // namespace splat
