#include "splat/cut.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cut.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/decode-inl.h"

#ifndef QS_SPLAT_CUT_ONCE
#define QS_SPLAT_CUT_ONCE
namespace splat {
namespace {

constexpr int kGroup = 8;  // lanes for a group of up to kMaxFanOut nodes
constexpr float kDiameterOfError = 20;  // a flat node may be this much wider than its error allows

// The view in model space.  Positions are relative to `pivot`, a point on the line of sight at depth
// `pivot_depth`, so that what is near in depth is small in float.
struct CutView {
    glm::dvec3 pivot{0};
    float pivot_depth = 0;
    float focal = 1;
    glm::vec3 right{0}, down{0}, forward{0};
    glm::vec3 plane[4];        // unit normals of the sides, inwards
    float plane_offset[4];     // distance of the pivot from them
    float corner_cosine = 1;   // of the angle between the line of sight and a corner of the picture
    float near = 0, far = 0;   // depths between which something is drawn
    float limit_error = 0;     // threshold on e f / z
    float limit_diameter = 0;  // threshold on 2 R f / z
    bool by_error = true, cull_backfaces = true, two_sided = false, has_colour = false;
    uint32_t colour = 0;       // of all, where there is no channel
};

// A node to be opened.
struct Opening {
    glm::vec3 at;  // centre - pivot
    float radius;
    glm::vec3 normal;
    int16_t cone;
    uint8_t children;
    bool is_inside;  // wholly inside the four sides
    uint32_t slot;
    uint64_t block;
};

// One group taken out of its block, a lane a node.
struct GroupCodes {
    int count;
    alignas(32) std::array<uint32_t, kGroup> normal{}, place{}, children{}, colour{};
    // 0 where the node ends the walk: a leaf, or its children are not there.
    alignas(32) std::array<uint32_t, kGroup> goes_on{};
    alignas(32) std::array<float, kGroup> radius{}, flatness{}, error{}, cone_cos{}, cone_sin{};
    // Above 0 where the node stands for surface on several sides: it is shown from the side it is seen from.
    alignas(32) std::array<float, kGroup> many_sided{};
    std::array<int16_t, kGroup> cone{};
};

// What became of a group's nodes that are to be opened: bits by lane, and their state.
struct GroupResult {
    uint32_t open = 0, inside = 0, frustum = 0, backface = 0, drawn = 0;
    uint32_t cut_short = 0;  // bits: drawn though neither small nor a leaf
    alignas(32) std::array<float, kGroup> at[3], offset[3], normal[3], radius;
    float error_px = 0;  // of what was drawn
};

GroupCodes take_group(const BlockView& block, uint32_t slot, int count, int parent_cone, bool culls, bool two_sided) {
    GroupCodes g;
    g.count = count;
    for (int k = 0; k < count; ++k) {
        const uint32_t attitude = block.attitude()[slot + uint32_t(k)], place = block.place()[slot + uint32_t(k)];
        const uint8_t shape = block.shape_of(slot + uint32_t(k));
        const auto i = size_t(k);
        g.children[i] = g.goes_on[i] = attitude & 7;
        g.normal[i] = attitude >> 5 & 1023u;
        g.place[i] = place;
        g.radius[i] = kRadius[place & 15];
        g.flatness[i] = kFlatness[shape & 3];
        g.error[i] = kErrorOfRadius[error_code(attitude, shape)];
        const int cone = decode_cone(int(attitude >> 3 & 3), parent_cone);
        g.cone[i] = int16_t(cone);
        g.many_sided[i] = two_sided || (cone < 0 && g.children[i] > 0) ? 1.0f : 0.0f;
        // A half-angle of 180 degrees never faces away.
        g.cone_cos[i] = culls && cone >= 0 ? kConeCos[cone] : -1.0f;
        g.cone_sin[i] = culls && cone >= 0 ? kConeSin[cone] : 0.0f;
        if (block.colour()) {
            const glm::u8vec3 c = decode_colour(block.colour()[slot + uint32_t(k)]);
            g.colour[i] = uint32_t(c.r) | uint32_t(c.g) << 8 | uint32_t(c.b) << 16;
        }
    }
    return g;
}

}  // namespace
}  // namespace splat
#endif  // QS_SPLAT_CUT_ONCE

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kGroup>;
using DU = hn::Rebind<uint32_t, D>;
using V = hn::Vec<D>;
using U = hn::Vec<DU>;
using M = hn::Mask<D>;

using V3 = Vector3<V>;

// Decodes a group, culls it, and appends what is to be drawn to `batch`, which has room for kGroup more (and a
// vector's spill).
void CutGroup(const GroupCodes& g, const Opening& parent, const Frame& frame, const CutView& view, geom::SplatBatch& batch,
              GroupResult& result) {
    const D d;
    const DU du;
    const int lanes = int(hn::Lanes(d));
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (int first = 0; first < g.count; first += lanes) {
        const auto i = size_t(first);
        const M valid = hn::FirstN(d, size_t(g.count - first));
        const V level = hn::Load(d, &g.radius[i]);
        const V3 n = DecodeNormal(d, hn::Load(du, &g.normal[i]), frame, parent.cone);
        const V3 offset = DecodeOffset(d, hn::Load(du, &g.place[i]), level, FrameAbout(d, n), parent.radius);
        const V3 at{hn::Add(hn::Set(d, parent.at.x), offset.x), hn::Add(hn::Set(d, parent.at.y), offset.y),
                    hn::Add(hn::Set(d, parent.at.z), offset.z)};
        const V radius = hn::Mul(hn::Set(d, parent.radius), level);
        const V bound = hn::Mul(radius, hn::Set(d, 1.0f + kSlack));

        const V3 forward = Set3(d, view.forward);
        const V ahead = Dot(forward, at);
        const V z = hn::Add(ahead, hn::Set(d, view.pivot_depth));
        M outside = hn::Or(hn::Lt(hn::Add(z, bound), hn::Set(d, view.near)),
                           hn::Gt(hn::Sub(z, bound), hn::Set(d, view.far)));
        M inside = hn::Gt(z, bound);
        if (!parent.is_inside) {
            for (int k = 0; k < 4; ++k) {
                const V distance = hn::Add(Dot(Set3(d, view.plane[k]), at), hn::Set(d, view.plane_offset[k]));
                outside = hn::Or(outside, hn::Lt(distance, hn::Neg(bound)));
                inside = hn::And(inside, hn::Gt(distance, bound));
            }
        }
        // All normals within the cone face away from the eye, seen from anywhere in the sphere.
        const V depth = hn::Set(d, view.pivot_depth);
        const V along = hn::Add(Dot(n, at), hn::Mul(depth, Dot(n, forward)));  // n . (centre - eye)
        const V square = hn::Max(zero, hn::Add(Dot(at, at), hn::Mul(depth, hn::Add(hn::Add(ahead, ahead), depth))));
        const V tangent = hn::Sqrt(hn::Max(zero, hn::Sub(square, hn::Mul(bound, bound))));
        const V cosine = hn::Load(d, &g.cone_cos[i]), sine = hn::Load(d, &g.cone_sin[i]);
        const M away = hn::And(hn::Gt(along, hn::Add(hn::Mul(bound, cosine), hn::Mul(tangent, sine))),
                               hn::Gt(hn::Mul(tangent, cosine), hn::Mul(bound, sine)));
        outside = hn::And(valid, outside);
        const M backface = hn::And(valid, hn::AndNot(outside, away));
        const M visible = hn::AndNot(hn::Or(outside, backface), valid);

        const V flat = hn::Load(d, &g.flatness[i]);
        const V facing = Dot(n, forward);
        // Nearest depth of what can be seen of the ellipsoid: where it reaches to the eye's plane beside the view,
        // the picture's corners are still this far ahead.
        const V reach = hn::Mul(radius, hn::Sqrt(hn::Max(zero, hn::Sub(one, hn::Mul(hn::Sub(one, hn::Mul(flat, flat)), hn::Mul(facing, facing))))));
        const V length = hn::Sqrt(square);
        const V nearest = hn::Max(
            hn::Set(d, view.near),
            hn::Max(hn::Sub(z, reach), hn::Mul(hn::Sub(length, radius), hn::Set(d, view.corner_cosine))));
        const V focal = hn::Set(d, view.focal);
        // What is drawn is the plane through the centre conjugate to the line of sight: the disc, seen from the
        // front, and up to the half thickness off it where it is seen on edge.
        const V most = hn::Div(hn::Max(zero, hn::Sub(hn::Abs(along), radius)), hn::Add(length, radius));
        const V cos2 = hn::Mul(most, most), lean = hn::Mul(hn::Mul(flat, flat), hn::Sub(one, cos2));
        const V off_disc = hn::Mul(flat, hn::Sqrt(hn::Div(lean, hn::Add(cos2, lean))));
        const V error = hn::Mul(hn::Mul(radius, hn::Add(hn::Load(d, &g.error[i]), off_disc)), focal);
        const V diameter = hn::Mul(hn::Add(radius, radius), focal);
        M small = hn::Le(diameter, hn::Mul(hn::Set(d, view.limit_diameter), nearest));
        if (view.by_error) small = hn::And(small, hn::Le(error, hn::Mul(hn::Set(d, view.limit_error), nearest)));
        const M ends = hn::RebindMask(d, hn::Eq(hn::Load(du, &g.goes_on[i]), hn::Zero(du)));
        const M drawn = hn::And(visible, hn::Or(ends, small));
        const M open = hn::AndNot(drawn, visible);

        const auto bits = [&](M m) {
            uint8_t byte[8] = {};
            hn::StoreMaskBits(d, m, byte);
            return uint32_t(byte[0]) << first;
        };
        result.open |= bits(open);
        result.cut_short |= bits(hn::AndNot(small, drawn));
        result.inside |= bits(inside);
        result.frustum += uint32_t(hn::CountTrue(d, outside));
        result.backface += uint32_t(hn::CountTrue(d, backface));
        if (parent.is_inside) result.inside = 0xff;
        hn::Store(at.x, d, &result.at[0][i]), hn::Store(at.y, d, &result.at[1][i]), hn::Store(at.z, d, &result.at[2][i]);
        hn::Store(offset.x, d, &result.offset[0][i]), hn::Store(offset.y, d, &result.offset[1][i]), hn::Store(offset.z, d, &result.offset[2][i]);
        hn::Store(n.x, d, &result.normal[0][i]), hn::Store(n.y, d, &result.normal[1][i]), hn::Store(n.z, d, &result.normal[2][i]);
        hn::Store(radius, d, &result.radius[i]);

        if (hn::AllFalse(d, drawn)) continue;
        const V safe = hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(error, nearest), hn::Inf(d));
        result.error_px = std::max(result.error_px, hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(drawn, safe))));
        const int to = batch.count;
        const M turned = hn::And(hn::Gt(along, zero), hn::Gt(hn::Load(d, &g.many_sided[i]), zero));
        const V sign = hn::IfThenElse(turned, hn::Neg(one), one);
        const V3 shown{hn::Mul(n.x, sign), hn::Mul(n.y, sign), hn::Mul(n.z, sign)};
        // Compressed in the register, then stored whole: compressing stores are slow on some processors.
        const auto put = [&](V value, float* channel) { hn::StoreU(hn::Compress(value, drawn), d, channel + to); };
        put(Dot(Set3(d, view.right), at), batch.x), put(Dot(Set3(d, view.down), at), batch.y), put(z, batch.z);
        put(Dot(Set3(d, view.right), shown), batch.nx), put(Dot(Set3(d, view.down), shown), batch.ny), put(Dot(forward, shown), batch.nz);
        put(radius, batch.radius), put(flat, batch.flatness);
        if (view.has_colour)
            hn::StoreU(hn::Compress(hn::Load(du, &g.colour[i]), hn::RebindMask(du, drawn)), du, batch.colour + to);
        else
            hn::StoreU(hn::Set(du, view.colour), du, batch.colour + to);
        const int count = int(hn::CountTrue(d, drawn));
        batch.count += count;
        result.drawn += uint32_t(count);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(CutGroup);

namespace {

constexpr size_t kTasks = 256;        // the top ends where this many nodes wait to be opened
constexpr size_t kCachedBlocks = 64;  // a thread's opened blocks, by number modulo this

// What a thread keeps between tasks and frames.
struct Walker {
    std::array<BlockView, kCachedBlocks> blocks;
    std::vector<Opening> level, next;
    geom::SplatBatch batch;

    BlockView& open_block(const Model& model, uint64_t number) {
        BlockView& view = blocks[number % kCachedBlocks];
        if (!view.is_open() || view.number() != number) view.open(model, number);
        return view;
    }
};

CutView make_cut_view(const Model& model, const geom::View& view, const CutOptions& options) {
    const Header& h = model.header();
    CutView v;
    const glm::dvec3 eye = (view.eye - h.origin) / h.scale;
    // The depth of the model's middle, as far as the eye is outside.
    const double depth = std::max(0.0, -glm::dot(eye, view.forward) - 1.0);
    v.pivot = eye + depth * view.forward;
    v.pivot_depth = float(depth);
    v.focal = float(view.focal_px);
    v.right = glm::vec3(view.right), v.down = glm::vec3(view.down), v.forward = glm::vec3(view.forward);
    const double half_w = 0.5 * view.width / view.focal_px, half_h = 0.5 * view.height / view.focal_px;
    const glm::dvec3 sides[4] = {view.right + half_w * view.forward, half_w * view.forward - view.right,
                                 view.down + half_h * view.forward, half_h * view.forward - view.down};
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 n = glm::normalize(sides[k]);
        v.plane[k] = glm::vec3(n);
        v.plane_offset[k] = float(depth * glm::dot(n, view.forward));
    }
    v.corner_cosine = float(1 / std::sqrt(1 + half_w * half_w + half_h * half_h));
    constexpr double kFarthest = std::numeric_limits<float>::max();
    v.near = float(std::min(view.near.value_or(0) / h.scale, kFarthest));
    v.far = float(std::min(view.far.value_or(kFarthest) / h.scale, kFarthest));
    v.by_error = options.by == CutBy::error;
    v.limit_error = float(options.threshold_px);
    v.limit_diameter = float(v.by_error ? options.threshold_px * double(kDiameterOfError) : options.threshold_px);
    // What near cuts open shows its inside.
    const bool is_cut_open = view.near && *view.near / h.scale > -glm::dot(eye, view.forward) - 1.0;
    v.cull_backfaces = options.cull_backfaces && !is_cut_open && !(h.flags & kOpenSurface);
    v.two_sided = h.flags & kCloud;
    v.has_colour = h.has_colour();
    const bool constant = h.flags & kConstantColour;
    v.colour = constant ? uint32_t(h.colour[0]) | uint32_t(h.colour[1]) << 8 | uint32_t(h.colour[2]) << 16 : 0x00e6e6e6;
    return v;
}

}  // namespace

void CutCounts::add(const CutCounts& o) {
    nodes_visited += o.nodes_visited, frustum_culled += o.frustum_culled, backface_culled += o.backface_culled;
    splats += o.splats, blocks_touched += o.blocks_touched, groups_missing += o.groups_missing;
    error_bound_px = std::max(error_bound_px, o.error_bound_px);
}

struct Cut::State {
    explicit State(const Model& m) : model(m), touched(std::make_unique<std::atomic<uint8_t>[]>(m.blocks_present())) {}

    const Model& model;
    // What the blocks that are there can hold, whatever the header says: more visits mean shared groups.
    const uint64_t most_nodes = std::min(model.header().node_count, model.blocks_present() * model.layout().capacity);
    CutView view;
    std::vector<Opening> tasks;
    geom::SplatBatch top_batch;
    std::vector<geom::SplatBatch> top_batches;  // splats of the top, drawn with task 0
    CutCounts top_counts;
    std::mutex mutex;
    CutCounts counts;
    tbb::enumerable_thread_specific<Walker> walkers;
    std::unique_ptr<std::atomic<uint8_t>[]> touched;  // by block: the frame it was last used in
    uint8_t frame = 0;

    // Opens one node: its group is cut, drawn nodes go to the batch, the others to push(lane, opening, offset).
    template <class Push>
    void open(const Opening& node, Walker& walker, geom::SplatBatch& batch, CutCounts& c, const Push& push) {
        BlockView& block = walker.open_block(model, node.block);
        if (touched[node.block].exchange(frame, std::memory_order_relaxed) != frame) ++c.blocks_touched;
        if (node.slot + node.children > block.node_count()) model.fault(node.block, "a sibling group goes beyond its nodes");
        GroupCodes codes = take_group(block, node.slot, node.children, node.cone, view.cull_backfaces, view.two_sided);
        if (!model.is_complete()) stop_at_missing(node, block, codes);
        GroupResult result;
        HWY_DYNAMIC_DISPATCH(CutGroup)(codes, node, frame_about(node.normal), view, batch, result);
        c.nodes_visited += node.children;
        c.frustum_culled += result.frustum, c.backface_culled += result.backface, c.splats += result.drawn;
        c.error_bound_px = std::max(c.error_bound_px, double(result.error_px));
        if (c.nodes_visited > most_nodes) model.fault(node.block, "is reached more than once");
        for (uint32_t cut = result.cut_short; cut; cut &= cut - 1)
            c.groups_missing += codes.children[size_t(__builtin_ctz(cut))] != 0;
        for (uint32_t open = result.open; open; open &= open - 1) {
            const auto k = size_t(__builtin_ctz(open));
            const GroupAt group = block.group_of(node.slot + uint32_t(k));
            if (group.block < node.block || (group.block == node.block && group.slot <= node.slot))
                model.fault(node.block, "a node's children stand before it");
            const Opening child{{result.at[0][k], result.at[1][k], result.at[2][k]}, result.radius[k],
                          {result.normal[0][k], result.normal[1][k], result.normal[2][k]}, codes.cone[k],
                          uint8_t(codes.children[k]), (result.inside >> k & 1) != 0, group.slot, group.block};
            push(child, glm::dvec3(result.offset[0][k], result.offset[1][k], result.offset[2][k]));
        }
    }

    void stop_at_missing(const Opening& node, BlockView& block, GroupCodes& codes) const {
        for (uint32_t k = 0; k < node.children; ++k)
            if (codes.children[k] != 0 && !model.has_block(block.group_of(node.slot + k).block)) codes.goes_on[k] = 0;
    }

    static bool is_full(const geom::SplatBatch& batch) { return batch.count + 4 * kGroup > geom::SplatBatch::kCapacity; }

    // The levels above the tasks, with centres in double.
    void walk_top() {
        top_counts = {};
        top_batches.clear();
        top_batch.count = 0;
        std::vector<std::pair<Opening, glm::dvec3>> level, next;
        const Node root = model.root();
        level.push_back({{glm::vec3(-view.pivot), 1.0f, root.normal, int16_t(root.cone), uint8_t(root.children), false, 0, 0}, glm::dvec3(0)});
        Walker& walker = walkers.local();
        while (!level.empty() && level.size() < kTasks) {
            next.clear();
            for (const auto& [node, centre] : level) {
                const glm::dvec3 from = centre;
                if (is_full(top_batch)) top_batches.push_back(top_batch), top_batch.count = 0;
                open(node, walker, top_batch, top_counts, [&](Opening child, const glm::dvec3& offset) {
                    const glm::dvec3 c = from + offset;
                    child.at = glm::vec3(c - view.pivot);
                    next.emplace_back(child, c);
                });
            }
            std::swap(level, next);
        }
        if (top_batch.count > 0) top_batches.push_back(top_batch);
        tasks.clear();
        for (const auto& [node, centre] : level) tasks.push_back(node);
    }

    void walk_task(const Opening& from, const Sink& sink, CutCounts& c) {
        Walker& walker = walkers.local();
        walker.batch.count = 0;
        walker.level.assign(1, from);
        while (!walker.level.empty()) {
            walker.next.clear();
            for (const Opening& node : walker.level) {
                if (is_full(walker.batch)) sink(walker.batch), walker.batch.count = 0;
                open(node, walker, walker.batch, c, [&](const Opening& child, const glm::dvec3&) { walker.next.push_back(child); });
            }
            std::swap(walker.level, walker.next);
        }
        if (walker.batch.count > 0) sink(walker.batch);
    }
};

Cut::Cut(const Model& model) : state_(std::make_unique<State>(model)) {}
Cut::~Cut() = default;

size_t Cut::begin(const geom::View& view, const CutOptions& options) {
    state_->view = make_cut_view(state_->model, view, options);
    if (++state_->frame == 0) {  // stamps of 256 frames ago
        for (uint64_t b = 0; b < state_->model.blocks_present(); ++b) state_->touched[b].store(0, std::memory_order_relaxed);
        state_->frame = 1;
    }
    state_->walk_top();
    state_->counts = state_->top_counts;
    return std::max<size_t>(1, state_->tasks.size());
}

void Cut::run(size_t task, const Sink& sink) {
    CutCounts c;
    if (task == 0)
        for (const geom::SplatBatch& batch : state_->top_batches) sink(batch);
    if (task < state_->tasks.size()) state_->walk_task(state_->tasks[task], sink, c);
    const std::scoped_lock lock(state_->mutex);
    state_->counts.add(c);
}

CutCounts Cut::counts() const { return state_->counts; }

}  // namespace splat
#endif
