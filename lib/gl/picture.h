// Pictures on their way from GL to a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/objects.h"
#include "render/frame.h"

namespace gl {

// Reads a part of a frame that was drawn into a framebuffer of kUints2, which is bound: inverse depth (its
// bits) and colour, 0xffBBGGRR, or 0 where nothing was drawn.  `step`: how many pixels on a side were drawn
// for each of the frame's, odd; the middle one is taken.  Depths are `unit` / inverse depth.  `buffer` is
// kept for the next time.
void read_part(const Use& gl, const Part& part, int step, double unit, glm::u8vec3 background,
               std::vector<uint32_t>& buffer, render::Frame& frame);

}  // namespace gl
