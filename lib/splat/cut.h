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
// Leaves that are triangles are handed out as such where their circles (their nodes', which are somewhat
// larger than the smallest) are large enough on the screen, and as splats where they are not.  (Hybrid point
// and triangle viewer, section 3.3; there every leaf is a triangle.)  A corner of several triangles is the
// same in all of them, to the bit.
//
// What other surfaces hide can be left out, too, by a geom::OcclusionMap: after begin() come, once or twice,
// outline() of all tasks, the map's build() and sift() of all; then run() with the map.  The rest comes in
// the same order.
//
// Nodes whose children are not there wait for a block.  They can be listed, with the error that stays as long
// as it is not there, to ask for what is missed most.  (Streaming QSplat, section 3.2.)
//
// The walk is in single precision relative to a pivot near what is seen, but its top, where rounding would
// count most, is in double; subtrees below the top are tasks that may run on any thread.  The splats of a
// task come in a fixed order, whatever the number of threads.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "geom/camera.h"
#include "geom/occlusion.h"
#include "geom/splat_batch.h"
#include "geom/triangle_batch.h"
#include "splat/cut_profile.h"
#include "splat/model.h"

namespace splat {

enum class CutBy {
    error,     // projected error bound <= threshold, and projected diameter <= kDiameterOfError thresholds
    diameter,  // projected diameter <= threshold (the original's meaning)
};

constexpr float kDiameterOfError = 20;  // a flat node may be this much wider than its error allows

struct CutOptions {
    CutBy by = CutBy::error;
    double threshold_px = 1;     // 0 and less, and NaN, draw leaves only
    bool cull_backfaces = true;  // where the model's surface allows it
    // Where not null, waiting nodes are listed and numbered, each with the next after this one, and colours
    // are these numbers: 0 for what does not wait.  Several cuts may share it.
    std::atomic<uint32_t>* last_number = nullptr;
    // Least diameter of a leaf that is handed out as a triangle, where leaves are; 0: all of them.  In a
    // block most of whose leaves are smaller, twice that: it would be read for a few of them.
    double triangle_px = std::numeric_limits<double>::infinity();
};

// Whether leaves that are triangles may be handed out as such.
inline bool hands_out_triangles(const CutOptions& options) {
    return options.triangle_px < std::numeric_limits<double>::infinity();
}

// What is decided for a whole view.
enum class BackfaceTest { made, not_wanted, open_surface, cut_open_by_near };
enum class ColourFrom { channel, header, nowhere };
struct CutPlan {
    BackfaceTest backfaces = BackfaceTest::made;
    ColourFrom colour = ColourFrom::nowhere;
};

// Those drawn splats whose errors are the largest beyond the threshold: leaves, and nodes whose children are
// not there.  Which of them can be seen is known when the frame is drawn.
class LargestErrors {
  public:
    struct Splat {
        glm::vec3 centre;  // in view space, in the splats' unit
        float radius;      // likewise
        float error_px;    // projected bound on its error; infinity with the eye inside
    };
    static constexpr size_t kMost = 32;

    LargestErrors() = default;
    explicit LargestErrors(float least_px) : least_px_(least_px) {}
    // No splat with an error up to this is kept: that of the least, once there are kMost.
    float least_px() const { return least_px_; }
    void add(const Splat& splat);
    void add(const LargestErrors& others);
    std::span<const Splat> splats() const { return {splats_.data(), count_}; }

  private:
    float least_px_ = 0;
    size_t count_ = 0;
    std::array<Splat, kMost> splats_;
};

struct CutCounts {
    uint64_t nodes_visited = 0, frustum_culled = 0, backface_culled = 0, splats = 0;
    uint64_t occlusion_culled = 0;
    uint64_t triangles = 0;  // leaves handed out as such; those without area have nothing to show
    // Nodes held against the picture's sides: those that were not wholly between them further up.
    uint64_t side_tests = 0;
    uint32_t side_test_level = 0;  // the deepest level with such nodes; that of the root's children is 1
    uint64_t blocks_touched = 0;
    uint64_t closed = 0;          // of the splats, nodes that a smaller threshold would open
    uint64_t groups_missing = 0;  // child groups, and triangles, that were wanted and are not there
    // No drawn point is further from the surface; infinity with the eye inside a splat.
    double error_bound_px = 0;
    LargestErrors largest;      // of those of splats that are beyond the threshold
    double other_error_px = 0;  // the bound but for all of these
    void add(const CutCounts& o);
};

// A node that is drawn although it should be opened, or a leaf that lacks its triangle.
struct WaitingNode {
    uint64_t block;  // that is not there
    uint32_t number;
    uint32_t level;    // of the tree; 0 is the root
    glm::vec3 centre;  // in view space, in the splats' unit
    float radius;      // model units
    float error_px;    // projected bound on its error; infinity with the eye inside
    float diameter_px;
};

class Cut {
  public:
    explicit Cut(const Model& model);  // which lives longer
    ~Cut();

    // Walks the top; returns the number of tasks (>= 1).  `view` is in world space.  `unit`: splats are
    // handed out in model units (world units / header().scale) times this.
    size_t begin(const geom::View& view, const CutOptions& options, double unit = 1);

    // Walks a task's first levels, down to nodes of some 80 pixels, and shows the map what they hold; called
    // a second time, after sift(), it goes on to nodes of some 40 pixels, but for what is hidden.  Different
    // tasks may be outlined at once.  Throws as run() does.
    void outline(size_t task, geom::OcclusionMap& map);

    // How many of an outlined task's nodes wait to be opened, and how many of these the map hides.
    struct Sifted {
        size_t waiting = 0, hidden = 0;
    };
    Sifted sift(size_t task, geom::OcclusionMap& map);

    // Walks one task, from where outline() left it, handing out its splats, and its triangles where
    // triangle_px is finite, but for what `map` hides.  May be called again for the same frame.  Different
    // tasks may run at once. Throws core::Error where the file is damaged.
    using Sink = std::function<void(const geom::SplatBatch&)>;
    using TriangleSink = std::function<void(const geom::TriangleBatch&)>;
    void run(size_t task, const Sink& sink, geom::OcclusionMap* map = nullptr,
             const TriangleSink& triangles = {});

    // Of all that was walked since begin().
    CutCounts counts() const;
    CutPlan plan() const;

    // Of all that was walked since begin() with last_number: in an order that the threads do not change.
    std::vector<WaitingNode> waiting() const;
    // Whether a block was used in any walk so far.
    bool has_used(uint64_t block) const;

    // What cuts of the view would hold, by threshold, from limits.finest_px (not options.threshold_px) up: an
    // estimate by a walk over a sample of the nodes.  Between the walks of frames, not during one.
    CutProfile profile(const geom::View& view, const CutOptions& options, const ProfileOptions& limits) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace splat
