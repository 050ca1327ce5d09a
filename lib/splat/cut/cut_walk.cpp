#include "splat/cut/cut_walk.h"

namespace splat {

namespace {

// The top ends where this many nodes wait to be opened; twice as many cut the dragon into 1216 tasks, whose
// short levels fill vectors badly and took 10 % more of a frame.
constexpr size_t kTasks = 128;

}  // namespace

void Cut::State::count_side_tests(std::span<const Opening> nodes, CutCounts& c) {
    for (const Opening& node : nodes) {
        if (node.is_inside) continue;
        c.side_tests += node.children;
        c.side_test_level = std::max(c.side_test_level, node.level + 1u);
    }
}

void Cut::State::check_groups(std::span<const Opening> nodes, const BlockView& block) const {
    for (const Opening& node : nodes)
        if (node.slot + node.children > block.node_count())
            model.fault(block.number(), "a sibling group goes beyond its nodes");
}

GroupAt Cut::State::group_of(BlockView& block, uint32_t slot) const {
    const GroupAt group = block.group_of(slot);
    if (group.block < block.number() || (group.block == block.number() && group.slot <= slot))
        model.fault(block.number(), "a node's children stand before it");
    return group;
}

Opening Cut::State::opening_of(const Chunk& chunk, size_t k, const GroupAt& group, uint16_t parent_level,
                               bool may_hide) {
    return {{chunk.at[0][k], chunk.at[1][k], chunk.at[2][k]},
            chunk.radius[k],
            {chunk.normal[0][k], chunk.normal[1][k], chunk.normal[2][k]},
            int16_t(chunk.cone[k]),
            uint8_t(chunk.code[k] & 7),
            chunk.inside[k] != 0,
            may_hide,
            uint16_t(parent_level + 1),
            group.slot,
            group.block};
}

Opening Cut::State::root_opening(const CutView& v) const {
    const Node root = model.root();
    return {glm::vec3(-v.pivot),
            1.0f,
            root.normal,
            int16_t(root.cone),
            uint8_t(root.children),
            false,
            true,
            0,
            0,
            0};
}

// What should be opened and is not there is drawn.  That is found by cutting the groups as if all were there,
// which costs nearly nothing where all is, and once more where something is not.
void Cut::State::cut(std::span<const Opening> nodes, Walker& walker, BlockView& block,
                     geom::SplatBatch& batch, CutCounts& c) {
    Chunk& chunk = walker.chunk;
    const int first = batch.count;
    if (model.is_complete()) {
        cut_groups(nodes, block, view, chunk, batch, c);
        find_groups(walker, block);
    } else {
        const CutCounts before = c;
        chunk.missing.fill(0);
        cut_groups(nodes, block, view, chunk, batch, c);
        find_groups(walker, block);
        if (mark_missing(nodes, walker, block)) {
            batch.count = first;
            c = before;
            cut_groups(nodes, block, view, chunk, batch, c);
            find_groups(walker, block);
        }
    }
    if (view.last_number) number_waiting(nodes[0].level + 1u, walker, block, first, batch);
}

void Cut::State::find_groups(Walker& walker, BlockView& block) const {
    const Chunk& chunk = walker.chunk;
    for (uint32_t i = 0; i < chunk.open_count; ++i)
        walker.groups[i] = group_of(block, chunk.slot[chunk.open[i]]);
}

// Of the chunk's nodes that are to be opened, and of its triangles.  False where none is missing.
bool Cut::State::mark_missing(std::span<const Opening> nodes, Walker& walker, const BlockView& block) const {
    Chunk& chunk = walker.chunk;
    bool is_any = false;
    const auto mark = [&, g = size_t(0), begin = uint32_t(0)](uint32_t lane) mutable {
        while (lane >= begin + nodes[g].children) begin += nodes[g++].children;
        chunk.missing[g] |= uint8_t(1u << (lane - begin));
        is_any = true;
    };
    for (auto [i, m] = std::pair(0u, mark); i < chunk.open_count; ++i)
        if (!model.has_block(walker.groups[i].block)) m(chunk.open[i]);
    if (chunk.triangle_count == 0) return is_any;
    const BlockTriangles& triangles = walker.triangles.open(model, block);
    if (!triangles.lacks()) return is_any;
    for (auto [i, m] = std::pair(0u, mark); i < chunk.triangle_count; ++i)
        if (triangles.find(chunk.slot[chunk.triangles[i]]).run == BlockTriangles::Place::kNone)
            m(chunk.triangles[i]);
    return is_any;
}

// Splats from `first` on are the chunk's, and their colours its lanes.
void Cut::State::number_waiting(uint32_t level, Walker& walker, BlockView& block, int first,
                                geom::SplatBatch& batch) {
    const Chunk& chunk = walker.chunk;
    std::vector<WaitingNode> found;
    for (int i = first; i < batch.count; ++i) {
        const uint32_t lane = batch.colour[i];
        batch.colour[i] = 0;
        if (!(chunk.shape[lane] & Chunk::kChildrenMissing)) continue;
        const uint32_t slot = chunk.slot[lane];
        const bool is_leaf = block.children_of(slot) == 0;
        const uint64_t missing =
            is_leaf ? *walker.triangles.open(model, block).lacks() : group_of(block, slot).block;
        batch.colour[i] = view.last_number->fetch_add(1, std::memory_order_relaxed) + 1;
        found.push_back({missing,
                         batch.colour[i],
                         level,
                         {batch.x[i], batch.y[i], batch.z[i]},
                         batch.radius[i] / view.unit,
                         chunk.needed[lane],
                         chunk.size[lane]});
    }
    if (found.empty()) return;
    const std::scoped_lock lock(mutex);
    waiting.insert(waiting.end(), found.begin(), found.end());
}

// Appends the chunk's triangles to the walker's batch, which has room for them.
void Cut::State::add_triangles(Walker& walker, const BlockView& block, CutCounts& c) {
    walker.triangles.add(model, block, walker.chunk, view,
                         [&](uint64_t number) { c.blocks_touched += touch(number); });
    c.triangles += walker.chunk.triangle_count;
}

std::span<const Opening> Cut::State::first_chunk(std::span<const Opening> nodes) {
    size_t n = 0;
    for (int count = 0; n < nodes.size() && nodes[n].block == nodes[0].block; ++n) {
        count += nodes[n].children;
        if (count > Chunk::kNodes) break;
    }
    return nodes.first(n);
}

// The levels above the tasks, with centres in double.  They are cut to the whole picture, whatever part
// of it is drawn, so that the tasks are the same, and with them the order of the splats.
void Cut::State::walk_top() {
    top_counts = {};
    top_counts.largest = LargestErrors(view.beyond_px());
    top_batches.clear();
    top_batch.count = 0;
    top_triangles.clear();
    const auto keep = [&](const geom::TriangleBatch& batch) { top_triangles.push_back(batch); };
    std::vector<std::pair<Opening, glm::dvec3>> level, next;
    level.push_back({root_opening(view), glm::dvec3(0)});
    Walker& walker = begin_walk();
    while (!level.empty() && level.size() < kTasks) {
        next.clear();
        for (const auto& [node, centre] : level) {
            const glm::dvec3 from = centre;
            if (is_full(top_batch)) top_batches.push_back(top_batch), top_batch.count = 0;
            if (is_full(walker.triangles.batch)) empty(walker.triangles.batch, keep);
            open({&node, 1}, walker, top_batch, top_counts, nullptr,
                 [&](Opening child, const glm::dvec3& offset) {
                     const glm::dvec3 c = from + offset;
                     child.at = glm::vec3(c - view.pivot);
                     next.emplace_back(child, c);
                 });
        }
        std::swap(level, next);
    }
    if (top_batch.count > 0) top_batches.push_back(top_batch);
    empty(walker.triangles.batch, keep);
    tasks.clear();
    for (const auto& [node, centre] : level) tasks.push_back(node);
}

void Cut::State::narrow_to_raster() {
    view.sides = view.raster_sides;
    for (Opening& task : tasks) task.is_inside = false;
}

// The thread's walker, with nothing in its batches, and no run decoded for another view.
Walker& Cut::State::begin_walk() {
    Walker& walker = walkers.local();
    walker.batch.count = 0;
    walker.triangles.begin();
    return walker;
}

// Cuts the walker's level, and makes the next one its own.
void Cut::State::walk_level(Walker& walker, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c) {
    walker.next.clear();
    for (std::span<const Opening> rest = walker.level, nodes; !rest.empty();
         rest = rest.subspan(nodes.size())) {
        nodes = first_chunk(rest);
        if (is_full(walker.batch)) empty(walker.batch, sinks.splats);
        if (is_full(walker.triangles.batch)) empty(walker.triangles.batch, sinks.triangles);
        open(nodes, walker, walker.batch, c, map,
             [&](const Opening& child, const glm::dvec3&) { walker.next.push_back(child); });
    }
    std::swap(walker.level, walker.next);
}

void Cut::State::walk_task(size_t task, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c) {
    Walker& walker = begin_walk();
    TaskOutlines& made = outlines[task];
    if (made.count == 0) {
        walker.level.assign(1, tasks[task]);
    } else {
        // Later outlines lack what the first one hid.
        if (map && map->is_repeated()) made.count = 1;
        for (int k = 0; k < made.count; ++k) made.of[size_t(k)].hand_out(walker.batch, sinks);
        start_from(made.last(), walker, map, c);
    }
    while (!walker.level.empty()) walk_level(walker, sinks, map, c);
    empty(walker.batch, sinks.splats), empty(walker.triangles.batch, sinks.triangles);
}

}  // namespace splat
