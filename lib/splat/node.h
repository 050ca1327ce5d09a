// The node code: 36 bits that place a flat ellipsoid in its parent's sphere.
//
//     attitude  bits 0-2   children: 0 a leaf, 1..7
//               bits 3-4   cone: 0..2 -> index of the parent's cone + (2 - code); 3: any direction
//               bits 5-14  normal, 31 x 31 codes over the parent's cone (over the sphere where it has none)
//               bit  15    high bit of the error code
//     place     bits 0-3   radius level
//               bits 4-10  centre across the node's own normal: 11 x 11 steps
//               bits 11-15 centre along it: 32 steps
//     shape     bits 0-1   flatness
//               bits 2-3   low bits of the error code
//
// All lengths are relative to the parent's decoded radius, so that coding errors do not add up
// down the tree.  Every code obeys |centre| + (1 + kSlack) r <= 1 + kSlack: the culling spheres, of
// (1 + kSlack) times the radius, nest for any bit pattern whatever.  The arithmetic is single
// precision without fused multiply-add, and a file's meaning depends on it.
//
// Rusinkiewicz, Levoy.  QSplat.  2000 (the hierarchy).  Where and why this differs: man/qs.5.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace splat {

constexpr float kSlack = 0.12f;
constexpr int kNormalSteps = 31;  // odd, so that the axis itself has a code
constexpr int kRadiusLevels = 16;
constexpr int kAcrossSteps = 11, kAlongSteps = 32;
constexpr float kAcrossLinear = 0.7f, kAlongLinear = 0.35f;  // slopes of the lattice's steps at the middle

// r of each level: closest where children of full groups lie, and 1 for the child that is as large as
// its parent.
inline constexpr float kRadius[kRadiusLevels] = {0.200f, 0.245f, 0.280f, 0.310f, 0.340f, 0.370f,
                                                 0.400f, 0.432f, 0.466f, 0.502f, 0.545f, 0.595f,
                                                 0.655f, 0.730f, 0.840f, 1.0f};
inline constexpr float kFlatness[4] = {0.035f, 0.12f, 0.36f, 1.0f};
// By flatness; those of any shape may reach 2 where it stands over a hole.  Closest where the nodes one and
// two levels above leaves lie, which are what is drawn at a pixel: with steps of nearly 2 there, x16 takes a
// tenth more splats for 35 dB.
inline constexpr float kErrorOfRadius[4][8] = {{0.1f, 0.16f, 0.25f, 0.38f, 0.55f, 0.8f, 1.2f, 2.0f},
                                               {0.1f, 0.16f, 0.25f, 0.38f, 0.55f, 0.8f, 1.2f, 2.0f},
                                               {0.15f, 0.25f, 0.36f, 0.5f, 0.68f, 0.92f, 1.3f, 2.0f},
                                               {0.3f, 0.45f, 0.6f, 0.75f, 0.9f, 1.1f, 1.4f, 2.0f}};

// Cones: half-angle of index k is kConeDegrees[k]; -1 is any direction.
constexpr int kConeCount = 8;
inline constexpr float kConeSin[kConeCount] = {0.98480775f, 0.76604444f, 0.52991926f, 0.34202014f,
                                               0.21814324f, 0.13917310f, 0.08715574f, 0.05582150f};
inline constexpr float kConeCos[kConeCount] = {0.17364818f, 0.64278761f, 0.84804810f, 0.93969262f,
                                               0.97591676f, 0.99026807f, 0.99619470f, 0.99844076f};
// tan(half / 2): the cap is flattened by stereographic projection.
inline constexpr float kConeTan[kConeCount] = {0.83909963f, 0.46630766f, 0.28674539f, 0.17632698f,
                                               0.11040103f, 0.06992681f, 0.04366094f, 0.02793253f};

// Index of a node's cone from its 2-bit code and its parent's index (-1 counts as 0 for the steps).
inline int decode_cone(int code, int parent_cone) {
    if (code == 3) return -1;
    const int base = parent_cone < 0 ? 0 : parent_cone;
    const int index = base + 2 - code;
    return index < kConeCount ? index : kConeCount - 1;
}

// Two directions across n.  Duff et al.  Building an orthonormal basis, revisited.  JCGT 2017.
struct Frame {
    glm::vec3 t1, t2, n;
};
inline Frame frame_about(const glm::vec3& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1.0f + sign * (n.x * n.x * a), sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

// The normal of a 10-bit code under a parent's frame and cone.
inline glm::vec3 decode_normal(uint32_t code, const Frame& parent, int parent_cone) {
    const uint32_t row = code / kNormalSteps;
    const float x = (float(code % kNormalSteps) - 15.0f) / 15.0f;
    const float y = (float(row < kNormalSteps ? row : kNormalSteps - 1) - 15.0f) / 15.0f;
    float nx, ny, nz;
    if (parent_cone < 0) {  // octahedron in model axes
        const float ax = std::fabs(x), ay = std::fabs(y);
        nz = 1.0f - ax - ay;
        nx = nz < 0.0f ? std::copysign(1.0f - ay, x) : x;
        ny = nz < 0.0f ? std::copysign(1.0f - ax, y) : y;
    } else {
        const float px = x * kConeTan[parent_cone], py = y * kConeTan[parent_cone];
        const float q = px * px + py * py;
        const float k = 1.0f / (1.0f + q);
        const float lx = 2.0f * px * k, ly = 2.0f * py * k, lz = (1.0f - q) * k;
        nx = lx * parent.t1.x + ly * parent.t2.x + lz * parent.n.x;
        ny = lx * parent.t1.y + ly * parent.t2.y + lz * parent.n.y;
        nz = lx * parent.t1.z + ly * parent.t2.z + lz * parent.n.z;
    }
    const float s = 1.0f / std::sqrt(nx * nx + ny * ny + nz * nz);
    return {nx * s, ny * s, nz * s};
}

// Steps of the centre's lattice, in parts of the limit.  Closer about the middle: parents are coded larger
// than they need to be, and children lie near their parent's plane.
inline float across_step(int k) {
    const float u = (float(k) - 5.0f) * (1.0f / 5.0f);
    return u * (kAcrossLinear + (1.0f - kAcrossLinear) * std::fabs(u));
}
inline float along_step(int k) {
    const float u = (float(k) - 15.5f) * (1.0f / 16.0f);
    return u * (kAlongLinear + (1.0f - kAlongLinear) * std::fabs(u));
}
inline float centre_limit(int level) {
    return (1.0f + kSlack) * (1.0f - kRadius[level]);
}

// Offset of the centre from the parent's, in parts of the parent's radius; points beyond the limit are
// pulled back onto it.  `frame` is that of the node's own decoded normal.
inline glm::vec3 decode_offset(uint32_t place, const Frame& frame) {
    const int level = int(place & 15u);
    const float limit = centre_limit(level);
    const uint32_t across = place >> 4 & 127u;
    const uint32_t row =
        across / uint32_t(kAcrossSteps);  // 11 for codes that are not used: outside, pulled back
    float a = across_step(int(across % uint32_t(kAcrossSteps))), b = across_step(int(row));
    float c = along_step(int(place >> 11));
    const float q = a * a + b * b + c * c;
    const float s = q > 1.0f ? limit / std::sqrt(q) : limit;
    a *= s, b *= s, c *= s;
    return {a * frame.t1.x + b * frame.t2.x + c * frame.n.x, a * frame.t1.y + b * frame.t2.y + c * frame.n.y,
            a * frame.t1.z + b * frame.t2.z + c * frame.n.z};
}

// The least code that is not below an error.
inline uint32_t encode_error(float error, float radius, uint32_t flatness) {
    for (uint32_t code = 0; code < 7; ++code)
        if (error <= radius * kErrorOfRadius[flatness][code]) return code;
    return 7;
}
inline uint32_t error_code(uint32_t attitude, uint32_t shape) {
    return (attitude >> 15) << 2 | (shape >> 2 & 3u);
}
inline float error_of_radius(uint32_t attitude, uint32_t shape) {
    return kErrorOfRadius[shape & 3][error_code(attitude, shape)];
}

// 5:6:5 colour.
inline uint16_t encode_colour(glm::u8vec3 c) {
    const auto q = [](unsigned v, unsigned top) { return (v * top + 127u) / 255u; };
    return uint16_t(q(c.r, 31) << 11 | q(c.g, 63) << 5 | q(c.b, 31));
}
inline glm::u8vec3 decode_colour(uint16_t v) {
    const unsigned r = v >> 11, g = v >> 5 & 63u, b = v & 31u;
    return {uint8_t(r << 3 | r >> 2), uint8_t(g << 2 | g >> 4), uint8_t(b << 3 | b >> 2)};
}

// A decoded node, in model units (the root's sphere is the unit sphere about 0).
struct Node {
    glm::dvec3 centre{0};
    float radius = 1;  // across; also of the sphere that holds the ellipsoid
    glm::vec3 normal{0, 0, 1};
    float flatness = 1;  // half thickness / radius
    float error = 2;     // bound on the distance of the disc (the ellipsoid's middle) from the surface
    int cone = -1;
    int children = 0;  // 0: a leaf
    uint16_t colour = 0;
};

// Index of a node's flatness.
inline uint32_t flatness_code(const Node& node) {
    uint32_t code = 0;
    while (code < 3 && kFlatness[code] < node.flatness) ++code;
    return code;
}

// Decodes one node under its decoded parent.
inline Node decode_node(uint16_t attitude, uint16_t place, uint8_t shape, uint16_t colour, const Node& parent,
                        const Frame& parent_frame) {
    Node node;
    node.children = attitude & 7;
    node.cone = decode_cone(attitude >> 3 & 3, parent.cone);
    node.normal = decode_normal(attitude >> 5 & 1023u, parent_frame, parent.cone);
    const glm::vec3 offset = decode_offset(place, frame_about(node.normal));
    node.centre = parent.centre +
                  glm::dvec3(offset.x * parent.radius, offset.y * parent.radius, offset.z * parent.radius);
    node.radius = parent.radius * kRadius[place & 15];
    node.flatness = kFlatness[shape & 3];
    node.error = node.radius * error_of_radius(attitude, shape);
    node.colour = colour;
    return node;
}

}  // namespace splat
