// How far two pictures are from each other.
//
// SSIM: Wang, Bovik, Sheikh, Simoncelli.  Image quality assessment: from error visibility to structural
// similarity.  2004.
#pragma once

#include <cstdint>
#include <optional>

#include "render/frame.h"
#include "render/image.h"

namespace render {

// Depth, times focal_px / the reference's depth.  What is nearer behind the reference is its own surface,
// within its error: blended splats, cut at 1 pixel, are up to 8 behind it, and far sides tens and hundreds.
constexpr double kShowThroughPx = 16;

struct ImageDifference {
    double psnr_db = 0;         // all three channels, whole picture; infinity where equal
    double psnr_inside_db = 0;  // over pixels that both cover; infinity where equal or where there are none
    double ssim = 1;            // mean SSIM of BT.601 luma, 11x11 Gaussian window of sigma 1.5 wherever it
                      // fits (a picture smaller than it has a window of the picture's size); 1 where equal
    double coverage_iou = 1;  // silhouettes: intersection over union; 1 where both are empty
    double silhouette_growth =
        0;  // (covered by a, not by b) / covered by b; infinity where b covers nothing but a does
    uint64_t holes = 0;  // covered by b, not by a
    uint64_t holes_inside =
        0;                   // of these, those inside the silhouette of b, whose outline may be sampled
                             // otherwise: b covers the 3x3 pixels about them, as far as the picture has them
    int max_difference = 0;  // largest difference of a channel, 0..255
    int worst_x = 0,
        worst_y = 0;  // top left of the 16x16 region (of a grid from 0, 0) with the largest squared error
    double worst_psnr_db = 0;  // of that region; infinity where the pictures are equal
    std::optional<double>
        depth_rmse_px;  // over pixels that both cover, where depths were given: depth difference
                        // times focal_px / the reference's depth; absent where no pixel is shared
    std::optional<uint64_t> show_through;  // pixels inside the silhouette of b, as above, where a shows what
                                           // b hides: kShowThroughPx behind all that b has in the 3x3 about
                                           // them; absent where no depths were given
};

// `a` is judged against `b`.  Sizes must agree (core::Error).  Without depth, a pixel is covered where it
// differs from `background`.  Frames with an alpha are laid over black.  Parallel; the same result for any
// number of threads.
ImageDifference compare(const Image& a, const Image& b, glm::u8vec3 background);
ImageDifference compare(const Frame& a, const Frame& reference, double focal_px);

// A picture of |a - b|, brightened: 8 times the difference, clamped; pixels only in a are red, only in b
// blue.
Image difference_picture(const Image& a, const Image& b, glm::u8vec3 background);

}  // namespace render
