// Cutting a model for a view: which nodes to draw, found by walking the tree from the root.
//
// A node is skipped where its culling sphere is outside the view (its near and far too) or all its normals
// face away (unless near cuts the model, whose inside then shows), drawn where its error (or diameter) is
// small enough on the screen, where it is a leaf, or where its children are not there yet, and opened
// otherwise. (Streaming QSplat, section 3.1 and figure 3.)
//
// Where the view is a part of a picture, its splats are those of the whole that it may show, in the same
// order.
//
// The walk is in single precision relative to a pivot near what is seen, but its top, where rounding would
// count most, is in double; subtrees below the top are tasks that may run on any thread.  The splats of a
// task come in a fixed order, whatever the number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "geom/camera.h"
#include "geom/splat_batch.h"
#include "splat/model.h"

namespace splat {

enum class CutBy {
    error,     // projected error bound <= threshold, and projected diameter <= 20 thresholds
    diameter,  // projected diameter <= threshold (the original's meaning)
};

struct CutOptions {
    CutBy by = CutBy::error;
    double threshold_px = 1;    // >= 0; 0 draws leaves only
    bool cull_backfaces = true; // where the model's surface allows it
};

struct CutCounts {
    uint64_t nodes_visited = 0, frustum_culled = 0, backface_culled = 0, splats = 0;
    uint64_t blocks_touched = 0;
    uint64_t groups_missing = 0;   // child groups that were wanted and are not there
    double error_bound_px = 0;     // no drawn point is further from the surface; infinity with the eye inside a splat
    void add(const CutCounts& o);
};

class Cut {
  public:
    explicit Cut(const Model& model);  // which lives longer
    ~Cut();

    // Walks the top; returns the number of tasks (>= 1).  `view` is in world space.
    size_t begin(const geom::View& view, const CutOptions& options);

    // Walks one task, handing out its splats, in model units (world units / header().scale).  Different tasks
    // may run at once.  Throws core::Error where the file is damaged.
    using Sink = std::function<void(const geom::SplatBatch&)>;
    void run(size_t task, const Sink& sink);

    // After all tasks ran.
    CutCounts counts() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace splat
