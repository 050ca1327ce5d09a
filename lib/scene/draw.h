// Drawing a model: its cut for a view, splatted into a frame.
#pragma once

#include <memory>

#include "geom/camera.h"
#include "render/frame.h"
#include "render/splatter.h"
#include "splat/cut.h"
#include "splat/model.h"

namespace scene {

struct DrawOptions {
    splat::CutOptions cut;
    render::SplatKind kind = render::SplatKind::smooth;
    render::Shade shade = render::Shade::lit;
    glm::u8vec3 background{0, 0, 0};
};

// What a frame cost.
struct DrawReport {
    splat::CutCounts counts;  // error_bound_px: infinity for squares and circles, which leave the ellipsoids
    double traverse_ms = 0;   // cut, and handing its splats to the painter
    double draw_ms = 0;       // set-up, drawing and shading
};

// Draws one model again and again; buffers are kept from frame to frame.
class ModelPainter {
  public:
    // `model` lives longer.  `painter`: of the back end that is to draw; not null.
    explicit ModelPainter(const splat::Model& model, std::unique_ptr<render::SplatPainter> painter =
                                                         std::make_unique<render::Splatter>());
    // Depths are in world units.
    DrawReport draw(const geom::View& view, const DrawOptions& options, render::Frame& frame);

  private:
    const splat::Model& model_;
    splat::Cut cut_;
    std::unique_ptr<render::SplatPainter> painter_;
};

}  // namespace scene
