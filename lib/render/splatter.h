// The CPU splatter: flat ellipsoids in, a shaded frame out.
//
// Splats come in batches from numbered tasks (subtrees of a model).  Each task's splats are set up
// (projected, 8 at a time) and sorted into square tiles of the screen; then each tile is drawn on
// its own by one thread, taking the tasks in the order of their numbers, so that the frame is the same
// for any number of threads and order-dependent blending needs one pass only.
//
// The ellipsoid's arithmetic (centre p, normal n, radius R across, h = rho R along n, all in view
// space): g = 1/rho^2 - 1, u = p + g (n.p) n, s = p.u, k = 1 - R^2/s, and for e = the offset in
// the plane z = 1 from p/p_z:
//     inside  <=>  R^2/z0^2 + 2 R^2 (e.u)/(s z0) + (e.u)^2/s - k (e.e + g (n.e)^2) >= 0
//     1/depth  =  1/z0 + (e.u)/s        (the polar plane: the middle of the chord)
#pragma once

#include <cstdint>
#include <memory>

#include "geom/camera.h"
#include "geom/splat_batch.h"
#include "render/frame.h"

namespace render {

using geom::SplatBatch;

struct SplatterOptions {
    SplatKind kind = SplatKind::smooth;
    Shade shade = Shade::lit;
    bool has_colour = false;
    glm::u8vec3 background{0, 0, 0};
};

class Splatter {
  public:
    Splatter();
    ~Splatter();

    // Starts a frame.  `task_count`: how many tasks will call add(); memory of earlier frames is reused.
    void begin(const geom::View& view, const SplatterOptions& options, size_t task_count);

    // Adds a batch of one task; different tasks may be added from different threads at once, one task's
    // batches by one thread in their order.  Splats that contain the eye, or reach behind the near
    // plane (z <= 0 somewhere on the ellipsoid), are drawn as a disc covering what they may cover, or
    // left out where wholly behind the eye.
    void add(size_t task, const SplatBatch& batch);

    // Call after the last add() of a task (sorts its splats into tiles).
    void end_task(size_t task);

    // Draws and shades all tiles in parallel.
    void finish(Frame& frame);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace render
