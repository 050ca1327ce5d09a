// Depth images as bytes, coded without loss of what they hold (depths were rounded before).
//
// planes: the default.  A mask of the pixels with a surface; depths as residuals of a plane through three
// neighbours,
//     in byte planes; colours as differences of channels, residuals likewise; every plane zstd, level 1.
//     Stripes of rows are coded apart from each other, on all cores.
// lzw:    the paper's, for comparison: colour and depth of every pixel, 7 bytes, LZW with codes of 9 to 16
// bits.
//     Depths are coded as single-precision view depths where the coding has 23 bits, so as codes otherwise.
//
// The paper, section 4.3; Welch.  A technique for high-performance data compression.  1984.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ppve/depth_image.h"

namespace ppve {

enum class Codec : uint8_t { planes = 0, lzw = 1 };

// The image's arrays (not its frustum, coding and footprint, which stand in the message).  Parallel; the same
// bytes for any number of threads.
std::vector<std::byte> encode(const DepthImage& image, Codec codec);

// Fills the image's arrays, normals where the message says so; its frustum (checked) is set.  Pixels without
// a surface get 0 in all arrays. Parallel.  Throws core::Error "depth image: ..." for anything that encode()
// does not write; memory as the frustum's size says, whatever the bytes do.
void decode(std::span<const std::byte> bytes, Codec codec, bool has_normals, DepthImage& image);

}  // namespace ppve
