// Depth images: colour and depth (and normals, when asked) of what is seen through a frustum, one sample a
// pixel.
//
// Depth is an integer, the same on both sides to the bit: the sampler rounds first, and nobody uses anything
// finer. A larger code is nearer; planes stay planes, so that they can be predicted:
//   perspective:   the leading bits of 1/z, as floating point with `bits` bits of mantissa.  A sample is off
//   by at
//                  most focal_px * 2^-(bits+1) pixels of its own view, seen from any side, whatever near and
//                  far.
//   orthographic:  (far - z) in steps of 2^-bits world units: focal_px * 2^-(bits+1) pixels likewise.
//
// Ge and others.  Point-based VR visualization for large-scale mesh datasets by real-time remote computation.
// 2006, section 4.1.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "geom/camera.h"

namespace ppve {

constexpr int kMostSide = 16384;           // pixels of a depth image, a side
constexpr double kMostCoordinate = 1e100;  // of eyes and surfaces, world units
constexpr double kLeastDepth = 1e-100, kMostDepth = 1e100;

enum class Projection : uint8_t { perspective = 0, orthographic = 1 };

// What is seen.  `view` has no margins; right, down and forward are orthonormal within 1e-9, of either hand
// (a mirrored matrix is a frustum as any other).  Orthographic: focal_px is pixels in a world unit, a point
// of view space (x, y, z) is at principal() + focal_px * (x, y), and depths may be negative but for near and
// far. Without near or far the depth is bounded by kLeastDepth and kMostDepth alone.
struct Frustum {
    geom::View view{};
    Projection projection = Projection::perspective;
};

// Throws core::Error "<where>: ..." where a frustum is not as above: a size outside 1 to kMostSide, a number
// that is not finite or out of range, axes that are not orthonormal, not 0 < near < far.
void check(const Frustum& frustum, const std::string& where);

// How depths of one image become codes from 1 to 2^32 - 1; 0 means that nothing is there.
struct DepthCoding {
    Projection projection = Projection::perspective;
    int32_t bits = 16;  // of mantissa (1 to 52); orthographic: steps are 2^-bits (-1000 to 1000)
    int64_t base = 0;   // what codes are counted from

    // Of a depth along the line of sight; depths outside the range have the nearest code that is in it.
    uint32_t code(double depth) const;
    // Of a code that is not 0.  Monotone: a larger code is nearer.
    double depth(uint32_t code) const;
};

// Whether all codes are depths: for codings from outside.
bool is_valid(const DepthCoding& coding);

// The coarsest coding that moves no sample by more than `bound_px` pixels of the frustum's view, for depths
// from `nearest` to `farthest` (0 < nearest <= farthest, orthographic: any); or, where 2^32 codes are too few
// for that, the finest that has a code for all of them.
DepthCoding choose_coding(const Frustum& frustum, double bound_px, double nearest, double farthest);

// What a coding is off by at most, pixels.
double bound_px(const DepthCoding& coding, double focal_px);

// The bits of a single-precision 1/z (or what is as fine, orthographic): the paper's lossless maps.
constexpr int kFloatMantissaBits = 23;

struct DepthImage {
    Frustum frustum{};
    DepthCoding coding{};
    // Distance of neighbouring samples, in pixels of the frustum's view.  1, but for an image that refines
    // others of the same view, shifted by a part of a pixel.
    double footprint_px = 1;

    // By pixel, row 0 on top.
    std::vector<uint32_t> depth;   // codes; 0: no surface
    std::vector<uint32_t> colour;  // 0x00BBGGRR; 0 where no surface is
    std::vector<uint16_t> normal;  // empty, or as octahedral_code(), in world space; 0 where no surface is

    int width() const { return frustum.view.width; }
    int height() const { return frustum.view.height; }
    size_t pixels() const { return size_t(width()) * size_t(height()); }
    size_t samples() const;  // pixels with a surface

    // Makes the arrays as large as the frustum's raster, and empty.
    void clear(bool with_normals);
};

// World position of the sample with depth `code` in pixel (i, j): its centre, at depth coding.depth(code).
// The same bits on every machine (IEEE doubles, no contraction).
glm::dvec3 position_of(const Frustum& frustum, const DepthCoding& coding, int i, int j, uint32_t code);

// Where a world position falls: pixels from the raster's upper left corner, and depth along the line of
// sight.
struct Projected {
    double x, y, depth;
};
Projected project(const Frustum& frustum, const glm::dvec3& world);

// World units between neighbouring samples across the line of sight, at a depth: depth / focal_px *
// footprint_px, orthographic 1 / focal_px * footprint_px.
double footprint(const Frustum& frustum, double footprint_px, double depth);

// Unit normals in 16 bits: two coordinates on an unfolded octahedron, 8 bits each, -127 to 127.  Comes back
// within 0.017 radians.  A zero or not finite normal has the code kUnknownNormal, which comes back as zero.
constexpr uint16_t kUnknownNormal = 0x8080;
uint16_t octahedral_code(const glm::vec3& normal);
glm::vec3 octahedral_normal(uint16_t code);

}  // namespace ppve
