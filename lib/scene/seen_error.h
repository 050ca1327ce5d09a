// The bound on the error of what can be seen in a frame, whose cut knows only what was drawn.
#pragma once

#include "geom/camera.h"
#include "render/frame.h"
#include "splat/cut.h"

namespace scene {

// No point that a pixel of `frame` shows is further from the surface, as projected, pixels: at most
// counts.error_bound_px, and less where the splats with the largest errors lie behind others.  `frame` has
// one sample a pixel.  unit: world units in one of the splats.
double seen_error_px(const splat::CutCounts& counts, double unit, const geom::View& view,
                     const render::Frame& frame);

}  // namespace scene
