// The farthest depth of each block of pixels: what lies behind it in all blocks that it may cover is hidden.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/exact_triangle.h"

namespace ppve {

class DepthPyramid {
  public:
    // Of words as in depth_words.h: nothing is hidden.
    void clear(int width, int height);
    // Parallel.
    void update(std::span<const uint64_t> words);
    // Whether all pixels of the box, which lies in the image, have something nearer than the word `nearest`.
    bool hides(const render::PixelBox& box, uint64_t nearest) const;

  private:
    int width_ = 0, height_ = 0, across_ = 0, down_ = 0;
    std::vector<uint64_t> farthest_;
};

}  // namespace ppve
