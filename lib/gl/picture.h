// Pictures on their way from GL to a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/objects.h"
#include "render/frame.h"

namespace gl {

// Throws core::Error for more than a sample a pixel, which is not drawn here.
void check_samples(const render::Look& look);

// Reads a part of a frame that was drawn into a framebuffer of kUints2, which is bound: inverse depth (its
// bits) and colour, 0xffBBGGRR, or 0 where nothing was drawn.  `step`: how many pixels on a side were drawn
// for each of the frame's, odd; the middle one is taken.  Depths are `unit` / inverse depth.  `buffer` is
// kept for the next time.  `look` has the background.
void read_part(const Use& gl, const Part& part, int step, double unit, const render::Look& look,
               std::vector<uint32_t>& buffer, render::Frame& frame);

}  // namespace gl
