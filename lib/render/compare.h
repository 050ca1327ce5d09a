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

struct ImageDifference {
    double psnr_db = 0;         // all three channels, whole picture; infinity where equal
    double psnr_inside_db = 0;  // over pixels that both cover; infinity where equal or where there are none
    double ssim = 1;            // mean SSIM of BT.601 luma, 11x11 Gaussian window of sigma 1.5 wherever it
                      // fits (a picture smaller than it has a window of the picture's size); 1 where equal
    double coverage_iou = 1;  // silhouettes: intersection over union; 1 where both are empty
    double silhouette_growth =
        0;  // (covered by a, not by b) / covered by b; infinity where b covers nothing but a does
    uint64_t holes = 0;      // covered by b, not by a
    int max_difference = 0;  // largest difference of a channel, 0..255
    int worst_x = 0,
        worst_y = 0;  // top left of the 16x16 region (of a grid from 0, 0) with the largest squared error
    double worst_psnr_db = 0;  // of that region; infinity where the pictures are equal
    std::optional<double>
        depth_rmse_px;  // over pixels that both cover, where depths were given: depth difference
                        // times focal_px / the reference's depth; absent where no pixel is shared
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
