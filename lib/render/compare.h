// How far two pictures are from each other.
#pragma once

#include <optional>

#include "render/frame.h"
#include "render/image.h"

namespace render {

struct ImageDifference {
    double psnr_db = 0;            // all three channels, whole picture; infinity where equal
    double psnr_inside_db = 0;     // over pixels that both cover
    double ssim = 1;               // mean SSIM of luma, 11x11 Gaussian window of sigma 1.5
    double coverage_iou = 1;       // silhouettes: intersection over union
    double silhouette_growth = 0;  // (covered by a, not by b) / covered by b
    uint64_t holes = 0;            // covered by b, not by a
    int max_difference = 0;        // largest difference of a channel, 0..255
    int worst_x = 0, worst_y = 0;  // top left of the 16x16 region with the largest squared error
    double worst_psnr_db = 0;      // of that region
    std::optional<double> depth_rmse_px;  // over pixels that both cover, where depths were given: depth difference
                                          // times focal_px / depth
};

// `a` is judged against `b`.  Sizes must agree (core::Error).  Without depth, a pixel is covered where it
// differs from `background`.
ImageDifference compare(const Image& a, const Image& b, glm::u8vec3 background);
ImageDifference compare(const Frame& a, const Frame& reference, double focal_px);

// A picture of |a - b|, brightened: 8 times the difference, clamped; pixels only in a are red, only in b blue.
Image difference_picture(const Image& a, const Image& b, glm::u8vec3 background);

}  // namespace render
