#include "splat/cut.h"

#include <algorithm>
#include <tuple>

#include "splat/cut/cut_walk.h"

namespace splat {

void CutCounts::add(const CutCounts& o) {
    nodes_visited += o.nodes_visited, frustum_culled += o.frustum_culled,
        backface_culled += o.backface_culled;
    occlusion_culled += o.occlusion_culled, triangles += o.triangles;
    splats += o.splats, closed += o.closed, blocks_touched += o.blocks_touched,
        groups_missing += o.groups_missing;
    side_tests += o.side_tests, side_test_level = std::max(side_test_level, o.side_test_level);
    error_bound_px = std::max(error_bound_px, o.error_bound_px);
    other_error_px = std::max(other_error_px, o.other_error_px);
    largest.add(o.largest);
}

void LargestErrors::add(const Splat& splat) {
    if (!(splat.error_px > least_px_)) return;
    const auto less = [](const Splat& a, const Splat& b) { return a.error_px < b.error_px; };
    const auto end = splats_.begin() + ptrdiff_t(count_);
    *(count_ < kMost ? splats_.begin() + ptrdiff_t(count_++) : std::min_element(splats_.begin(), end, less)) =
        splat;
    if (count_ == kMost) least_px_ = std::min_element(splats_.begin(), splats_.end(), less)->error_px;
}

void LargestErrors::add(const LargestErrors& others) {
    for (const Splat& splat : others.splats()) add(splat);
}

Cut::Cut(const Model& model) : state_(std::make_unique<State>(model)) {}
Cut::~Cut() = default;

size_t Cut::begin(const geom::View& view, const CutOptions& options, double unit) {
    state_->view = make_cut_view(state_->model, view, options);
    state_->view.unit = float(unit);
    // Stamps of 256 frames ago become one that is no frame's; 0 stays: never used.
    if (++state_->frame == 0) {
        for (uint64_t b = 0; b < state_->model.blocks_present(); ++b)
            if (state_->touched(b).load(std::memory_order_relaxed) != 0)
                state_->touched(b).store(1, std::memory_order_relaxed);
        state_->frame = 2;
    }
    state_->waiting.clear();
    state_->walk_top();
    if (view.width != view.picture_width() || view.height != view.picture_height())
        state_->narrow_to_raster();
    if (state_->outlines.size() < state_->tasks.size()) state_->outlines.resize(state_->tasks.size());
    for (TaskOutlines& made : state_->outlines) made.count = 0;
    state_->counts = state_->top_counts;
    return std::max<size_t>(1, state_->tasks.size());
}

void Cut::outline(size_t task, geom::OcclusionMap& map) {
    if (task >= state_->tasks.size()) return;
    CutCounts c;
    state_->outline(task, map, c);
    state_->add(c);
}

Cut::Sifted Cut::sift(size_t task, geom::OcclusionMap& map) {
    if (task >= state_->tasks.size()) return {};
    Outline& outline = state_->outlines[task].last();
    state_->sift(outline, map);
    Sifted sifted{outline.level.size(), 0};
    sifted.hidden =
        size_t(std::count(outline.sights.begin(), outline.sights.end(), geom::OcclusionMap::Sight::hidden));
    return sifted;
}

void Cut::run(size_t task, const Sink& sink, geom::OcclusionMap* map, const TriangleSink& triangles) {
    CutCounts c = state_->begin_counts();
    if (task == 0) {
        for (const geom::SplatBatch& batch : state_->top_batches) sink(batch);
        for (const geom::TriangleBatch& batch : state_->top_triangles) triangles(batch);
    }
    if (task < state_->tasks.size()) state_->walk_task(task, {sink, triangles}, map, c);
    state_->add(c);
}

CutCounts Cut::counts() const {
    return state_->counts;
}

CutPlan Cut::plan() const {
    return state_->view.plan;
}

std::vector<WaitingNode> Cut::waiting() const {
    std::vector<WaitingNode> nodes = state_->waiting;
    // Numbers are given as threads come by.
    std::sort(nodes.begin(), nodes.end(), [](const WaitingNode& a, const WaitingNode& b) {
        return std::tie(a.block, a.level, a.centre.x, a.centre.y, a.centre.z) <
               std::tie(b.block, b.level, b.centre.x, b.centre.y, b.centre.z);
    });
    return nodes;
}

bool Cut::has_used(uint64_t block) const {
    return state_->touched(block).load(std::memory_order_relaxed) != 0;
}

CutProfile Cut::profile(const geom::View& view, const CutOptions& options,
                        const ProfileOptions& limits) const {
    CutView v = make_cut_view(state_->model, view, options);
    v.is_profiled = true;
    v.sides = v.raster_sides;
    return state_->profile(v, limits, uint64_t(view.width) * uint64_t(view.height));
}

}  // namespace splat
