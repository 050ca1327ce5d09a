// The CPU splatter: flat ellipsoids and triangles in, a shaded frame out.
//
// Splats come in batches from numbered tasks (subtrees of a model).  Each task's splats are sorted into
// tiles of the screen; then each tile's are set up (projected, a vector at a time) and drawn on their
// own by one thread, taking the tasks in the order of their numbers, so that the frame is the same
// for any number of threads and order-dependent blending needs one pass only.  It is also the same
// for any instruction set: no fused multiply-add, no approximate reciprocals.
//
// A splat is the ellipsoid about p with radius R across and rho R along its normal n.  It covers the pixels
// whose centres its exact perspective outline contains: none is missing whose ray meets the ellipsoid shrunk
// by 1e-4, none is covered 1e-3 px outside (for R > 0.8 p_z: 1e-4 of the ellipsoid's size).  Depth is that of
// the eye's polar plane, 1/depth = d.u/s for a ray d = (x, y, 1), with u = p + (1/rho^2 - 1) (n.p) n and s =
// p.u; it runs between the two points where a ray meets the ellipsoid, is linear in the picture, and is
// bounded where the plane of a flat disc is not.  How the outline is found without cancellation:
// splat_outline-inl.h.
//
// What an ellipsoid covers is larger than the surface it stands for, which shows where that ends before
// another.  So a pixel shows the cores of splats, flatter and narrower ellipsoids, if it has any that its
// triangle does not hide, and what is but covered only where it has none: kCoverOrder in splat_record.h.
//
// Of each tile the triangles are drawn first (tile_triangles.h), so that the order in which they came among
// the splats is of no matter; then a pixel takes only the splats in front of its triangle.
//
// Of several samples a pixel each is drawn as a pixel of a larger picture would be, in tiles that are
// averaged as they are finished: a frame takes no more memory than one of a sample each.
//
// Lengths in view space from 1e-30 to 1e30 are safe; no input gives NaN or undefined behaviour.
#pragma once

#include <memory>

#include "geom/occlusion.h"
#include "render/backend.h"

namespace render {

// What the shading of a pixel needs of its splats; SplatKind::smooth blends only that.
struct ShadingNeeds {
    bool normals, colours;
};
inline ShadingNeeds needs_of(const SplatterOptions& options) {
    const Shade shade = options.look.shade;
    return {shade != Shade::flat, (options.has_colour || shade == Shade::level) && shade != Shade::normal};
}

class Splatter final : public SplatPainter {
  public:
    Splatter();
    ~Splatter() override;

    // Once warm, a frame like the last one allocates nothing.
    void begin(const geom::View& view, const SplatterOptions& options, size_t task_count) override;

    // A splat that reaches to the eye's plane (z = 0) covers exactly the pixels whose rays meet it before the
    // eye, at some 1 ms a screen; one that contains the eye covers the whole picture, at the depth where the
    // rays leave it.  Both give way to other splats within R of depth.  Left out: what is wholly behind the
    // eye, squares and circles with their centre behind it, and of every splat the pixels where its depth is
    // not between the view's near and far (to within 1e-6 of it).
    void add(size_t task, const SplatBatch& batch) override;
    // Covers and depths are MeshRaster's of the same corners; depths to within 1e-6 of them.
    void add(size_t task, const TriangleBatch& batch) override;
    void end_task(size_t task) override;

    // Sets up, draws and shades all tiles in parallel.
    void finish(Frame& frame) override;

    // The same for a frame that lacks what `map` hides.  Marks its blocks where that may show; once the map
    // is repeated, of a frame that was begun anew, writes those blocks only.  Where options.has_triangles is
    // not set, there are none, neither in the frame nor among what is hidden.
    void finish(Frame& frame, geom::OcclusionMap& map);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace render
