// Splats and triangles drawn by GL, as render::Splatter draws them.
//
// The splats are sent as they come, projected by the vertex shader, and drawn as points of the size of their
// outlines' boxes, or as rectangles where they are too large for that or reach towards the eye's plane; the
// fragment shader decides each pixel.  `square`, `circle` and `ellipse` take one pass with a depth test;
// `smooth` takes three: the greatest inverse depth of each pixel, sums over what is within its push of it,
// and the inverse depth of what weighs most there; then all pixels are shaded at once.
//
// Triangles are drawn before; a splat's fragment that lies behind one is left out.
//
// How it differs from render::Splatter: outlines are computed in single precision throughout, which moves
// them by up to 1e-4 px; `smooth` takes the greatest depth of all splats and not of those so far, so that its
// frame does not depend on their order; of splats at the same depth another may show; depths that differ
// by a factor of more than 1e37 in one frame are not told apart; and corners of triangles are moved to the
// driver's grid, by up to 1/512 px, and cut off where they are nearer than 1e-6 of the largest coordinate.
#pragma once

#include <memory>

#include "gl/device.h"
#include "render/backend.h"

namespace gl {

class SplatPainter final : public render::SplatPainter {
  public:
    explicit SplatPainter(std::unique_ptr<Device> device);
    ~SplatPainter() override;

    const Device& device() const;

    void begin(const geom::View& view, const render::SplatterOptions& options, size_t task_count) override;
    void add(size_t task, const render::SplatBatch& batch) override;
    void add(size_t task, const render::TriangleBatch& batch) override;
    void end_task(size_t) override {}

    // Throws core::Error where GL fails, as for want of memory: 36 bytes a splat and 108 a triangle, twice,
    // and of the picture, or the 4096 x 4096 of it that are drawn at a time, up to 68 a pixel.
    void finish(render::Frame& frame) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace gl
