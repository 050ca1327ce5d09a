// Splats blended by the rule that gl::SplatPainter promises for `smooth`, pixel by pixel in plain code: what
// is within its push of the greatest inverse depth of all splats counts.
#pragma once

#include <vector>

#include "render/backend.h"

namespace gl_test {

// The splats of a frame, as a model hands them out.
struct Splats {
    geom::View view;
    render::SplatterOptions options;
    std::vector<std::vector<render::SplatBatch>> tasks;
};

render::Frame draw_in_two_passes(const Splats& splats);

}  // namespace gl_test
