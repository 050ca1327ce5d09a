// Triangles on their way from a model's traversal to a renderer, beside its splats: in view space.
#pragma once

#include <cstdint>

namespace geom {

// View space and unit of length as in the frame's SplatBatches.  Structure of arrays; only the first `count`
// are valid.  A corner that two triangles share has the same bits in both.
struct TriangleBatch {
    static constexpr int kCapacity = 512;  // a multiple of every vector length
    int count = 0;
    alignas(64) float x[3][kCapacity], y[3][kCapacity], z[3][kCapacity];  // corners
    alignas(64) float nx[3][kCapacity], ny[3][kCapacity],
        nz[3][kCapacity];                    // unit normals there; flat: three times the same
    alignas(64) uint32_t colour[kCapacity];  // 0x00BBGGRR; grey models: ignored
};

}  // namespace geom
