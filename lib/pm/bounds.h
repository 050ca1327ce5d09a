// Codes of the bounds of nodes: radius and error on logarithmic lattices, cones of normals.
//
// Both sides of a connection decide by the decoded values, so decoding is exact arithmetic of IEEE doubles
// (+ - * / sqrt, powers of two) and no library function: the same bits everywhere.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace pm {

// Lengths in units of the model's longest side (unit space).
//     radius = 2^(code - 48), code 0..63          a step of 2: coarser costs splits only in close views
//     error  = 2^((code - 192) / 4), code 0..255  the one code that must be fine
// Encoders round up, idempotently: a value on the lattice keeps its code.  What is below the lattice is
// rounded up to code 0, so no error is 0 and a tolerance of 0 refines everything that can be seen.
constexpr uint8_t kMaxRadiusCode = 63;
double decode_radius(uint8_t code);
double decode_error(uint8_t code);
uint8_t encode_radius(double radius);  // 0 <= radius <= 2^15, or kMaxRadiusCode
uint8_t encode_error(double error);    // 0 <= error < 2^15.75, or 255

// A cone of normals: all of them within half_angle of axis.  Octahedral axis, 6 + 6 bits; half angle by 5
// bits,
//     tan(half_angle / 2) = code / 31, code 0..30; code 31: any direction, never culled.
constexpr uint8_t kAnyDirection = 31;
constexpr uint16_t kAxisCodes = 1 << 12;
struct Cone {
    glm::dvec3 axis{0, 0, 1};     // unit length
    double sine = 1, cosine = 0;  // of half_angle, <= 90 degrees; without meaning where any direction is
};
Cone decode_cone(uint16_t axis, uint8_t angle);

struct ConeCodes {
    uint16_t axis = 0;
    uint8_t angle = kAnyDirection;
};
// The narrowest code whose cone holds that about `axis` (any length > 0) of half_angle (radians, 0..pi).
ConeCodes encode_cone(const glm::dvec3& axis, double half_angle);

// Unit vectors in 16 bits, octahedral, 8 + 8: within 0.95 degrees.  Code 0xffff is "unknown", decoded as 0.
uint16_t encode_normal(const glm::dvec3& normal);
glm::dvec3 decode_normal(uint16_t code);

// What is known of a node: it bounds the input faces that touch a leaf below it.
struct NodeBounds {
    glm::dvec3 centre{0};  // unit space: the position of the node's vertex
    uint8_t error = 0, radius = 0;
    ConeCodes cone{};
};

}  // namespace pm
