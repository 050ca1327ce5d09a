// What a back end is: something that draws the splats of a cut, or a mesh, into a frame.  Splatter and
// MeshRaster are those of the CPU, and say to the pixel what is to be seen; others come as near to it as they
// can.
#pragma once

#include <cstddef>

#include "geom/camera.h"
#include "geom/splat_batch.h"
#include "geom/triangle_batch.h"
#include "render/frame.h"

namespace render {

using geom::SplatBatch;
using geom::TriangleBatch;

// A splat holds what it stands for, and more: where a part of a surface is splats and the part beside it is
// triangles, rims of splats would stand in front of triangles.  So splats are pushed back against triangles,
// and against nothing else: a triangle shows where its depth is at most the splat's times 1 + push_back_px /
// focal length in pixels.
constexpr double kPushBackPx = 2;  // less shows rims, more gains nothing

// has_colour: the batches' colours are the material, else 0.9 grey.
struct SplatterOptions {
    SplatKind kind = SplatKind::smooth;
    Look look{};
    bool has_colour = false;
    double depth_unit = 1;  // world units in a unit of the splats: depths of the frame are in world units
    double push_back_px = kPushBackPx;  // where splats are coarser than that: as coarse as they are
    bool has_triangles = false;         // there may be some, among what is left out as hidden, too
};

constexpr int kMostSamples = 65536;  // of a picture, a side

// Draws splats and triangles, frame after frame:  begin(), then for each task any number of add() and one
// end_task(), then finish().
class SplatPainter {
  public:
    virtual ~SplatPainter() = default;

    // Starts a frame that is, or is a part of, a picture of at most kMostSamples x kMostSamples samples.
    // `task_count`: how many tasks may call add(), numbered from 0.  Memory of earlier frames is reused.
    virtual void begin(const geom::View& view, const SplatterOptions& options, size_t task_count) = 0;

    // Adds a batch of one task; different tasks may be added from different threads at once, one task's
    // batches by one thread in their order.
    virtual void add(size_t task, const SplatBatch& batch) = 0;

    // Triangles are drawn as MeshPainter draws them, whatever the kind of the splats: they cover the pixels
    // whose centres they cover, both sides of them, are shaded with normals interpolated between their
    // corners, and do not blend.  Their corners are finite.  Shade::level gives them the colour of the finest
    // splats.  Among a task's splats they may come in any order.
    virtual void add(size_t task, const TriangleBatch& batch) = 0;

    // Call after the last add() of a task that had any.
    virtual void end_task(size_t task) = 0;

    // Draws what was added.  `frame` becomes the view's size and is written in full.
    virtual void finish(Frame& frame) = 0;
};

// Draws one mesh again and again.
class MeshPainter {
  public:
    virtual ~MeshPainter() = default;

    // Normals: the mesh's own; where it has none (or a zero one) area-weighted vertex normals.  Normals and
    // colours are interpolated perspective-correctly, and the interpolated normal is used as it is; both
    // sides of a triangle are drawn.  Shade::level means nothing for a triangle and is drawn as lit grey.  A
    // cloud draws nothing.  Points that are not between the view's near and far are not drawn, so that what
    // is behind them shows; without near the eye's plane is the near plane.  The frame is resized to the
    // view.
    virtual void draw(const geom::View& view, const Look& look, Frame& frame) = 0;
};

}  // namespace render
