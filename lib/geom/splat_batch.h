// Splats on their way from a model's traversal to a renderer: flat ellipsoids in view space.
#pragma once

#include <cstdint>

namespace geom {

// View space as in geom/camera.h, in one unit of length for all.  Structure of arrays; only the first
// `count` are valid.
struct SplatBatch {
    static constexpr int kCapacity = 512;  // a multiple of every vector length
    int count = 0;
    alignas(64) float x[kCapacity], y[kCapacity], z[kCapacity];     // centre
    alignas(64) float radius[kCapacity];                            // across, > 0, finite
    alignas(64) float nx[kCapacity], ny[kCapacity], nz[kCapacity];  // unit normal
    alignas(64) float flatness[kCapacity];                          // half thickness / radius, in (0, 1]
    alignas(64) uint32_t colour[kCapacity];                         // 0x00BBGGRR; grey models: ignored
};

}  // namespace geom
