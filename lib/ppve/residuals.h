// Pixels of a stripe as differences from what their neighbours foretell, and back; lossless, modulo 2^32 and
// 2^8.
//
// Depths are planes where surfaces are: W + N - NW.  Where a neighbour is missing its place is filled as the
// surface left of it goes on, on both sides alike, so that a surface that was left is met again with its old
// depth and slope. Colours, as G, R - G, B - G: the same, clamped between W and N, and filled from above.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ppve/pixel_runs.h"

namespace ppve {

struct Stripe {
    int width = 0, rows = 0;
    const PixelMask* mask = nullptr;
};

// `depth`, `colour`: the stripe's pixels.  Out: one a pixel with a surface, in order.  Depths: small ones of
// either sign are small numbers (zigzag).  Colours: 0x00BGR differences, signed bytes likewise.
void depth_residuals(const Stripe& stripe, const uint32_t* depth, std::vector<uint32_t>& out);
void colour_residuals(const Stripe& stripe, const uint32_t* colour, std::vector<uint32_t>& out);

// Back, into the pixels with a surface; the others are not written.  There is a residual for each pixel of
// the mask.
void restore_depths(const Stripe& stripe, std::span<const uint32_t> residuals, uint32_t* depth);
void restore_colours(const Stripe& stripe, std::span<const uint32_t> residuals, uint32_t* colour);

}  // namespace ppve
