// The walk behind Cut: the tree from the root down, level by level, a task at a time.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "core/address_space.h"
#include "splat/cut.h"
#include "splat/cut/cut_groups.h"
#include "splat/cut/cut_outline.h"
#include "splat/cut/cut_triangles.h"
#include "splat/cut/cut_view.h"

namespace splat {

constexpr size_t kCachedBlocks = 64;  // a thread's opened blocks, by number modulo this
constexpr uint32_t kLineNodes = 32;   // nodes in a cache line of a channel

// What a thread keeps between tasks and frames.
struct Walker {
    std::array<BlockView, kCachedBlocks> blocks;
    CutTriangles triangles;
    std::vector<Opening> level, next;
    Chunk chunk;
    std::array<GroupAt, Chunk::kNodes> groups;  // children of what is to be opened
    geom::SplatBatch batch;
    std::vector<geom::OcclusionMap::Surface> surfaces;
    geom::OcclusionMap::Spheres spheres;                          // to be looked at
    std::array<geom::OcclusionMap::Sight, Chunk::kNodes> sights;  // of what is to be opened

    BlockView& open_block(const Model& model, uint64_t number) {
        BlockView& view = blocks[number % kCachedBlocks];
        if (!view.is_open() || view.number() != number) view.open(model, number);
        return view;
    }
};

inline bool is_full(const geom::SplatBatch& batch) {
    return batch.count + Chunk::kLanes > geom::SplatBatch::kCapacity;
}
inline bool is_full(const geom::TriangleBatch& batch) {
    return batch.count + Chunk::kNodes > geom::TriangleBatch::kCapacity;
}
template <class Batch, class Taker>
void empty(Batch& batch, const Taker& sink) {
    if (batch.count > 0) sink(batch);
    batch.count = 0;
}

struct Cut::State {
    using Sight = geom::OcclusionMap::Sight;

    explicit State(const Model& m) : model(m), touched_in(m.blocks_present(), m.name()) {}

    const Model& model;
    // What the blocks that are there can hold, whatever the header says: more visits mean shared groups.
    const uint64_t most_nodes =
        std::min(model.header().node_count, model.node_blocks_present() * model.layout().capacity);
    CutView view;
    std::vector<Opening> tasks;
    geom::SplatBatch top_batch;
    std::vector<geom::SplatBatch> top_batches;  // splats of the top, drawn with task 0
    std::vector<geom::TriangleBatch> top_triangles;
    CutCounts top_counts;
    std::mutex mutex;
    CutCounts counts;
    tbb::enumerable_thread_specific<Walker> walkers;
    core::AddressSpace touched_in;  // by block: the frame it was last used in
    uint8_t frame = 0;
    std::vector<TaskOutlines> outlines;  // by task
    std::vector<WaitingNode> waiting;

    // Of a walk: errors that are among the frame's largest no more need not be kept.
    CutCounts begin_counts() {
        const std::scoped_lock lock(mutex);
        CutCounts c;
        c.largest = LargestErrors(counts.largest.least_px());
        return c;
    }
    // Of all walks of the frame since Cut::begin().
    void add(const CutCounts& c) {
        const std::scoped_lock lock(mutex);
        counts.add(c);
    }

    // ---- groups, cut_walk.cpp

    // Whether this is the block's first use in the frame.  It is nearly always touched already, which a load
    // tells for a tenth of an exchange.
    bool touch(uint64_t number) {
        return touched(number).load(std::memory_order_relaxed) != frame &&
               touched(number).exchange(frame, std::memory_order_relaxed) != frame;
    }
    std::atomic_ref<uint8_t> touched(uint64_t number) const {
        return std::atomic_ref(reinterpret_cast<uint8_t*>(touched_in.bytes().data())[number]);
    }

    // Opens nodes whose groups lie in one block: the groups are cut, drawn nodes go to the batch, the others
    // to push(opening, offset).
    template <class Push>
    void open(std::span<const Opening> nodes, Walker& walker, geom::SplatBatch& batch, CutCounts& c,
              geom::OcclusionMap* map, const Push& push) {
        const uint64_t number = nodes[0].block;
        BlockView& block = walker.open_block(model, number);
        c.blocks_touched += touch(number);
        check_groups(nodes, block);
        count_side_tests(nodes, c);
        cut(nodes, walker, block, batch, c);
        if (c.nodes_visited > most_nodes) model.fault(number, "is reached more than once");
        const Chunk& chunk = walker.chunk;
        if (chunk.triangle_count > 0) add_triangles(walker, block, c);
        if (map) look_at_opened(walker, *map);
        GroupAt asked{~uint64_t{0}, 0};
        for (uint32_t i = 0; i < chunk.open_count; ++i) {
            const size_t k = chunk.open[i];
            const Sight sight = map ? walker.sights[i] : Sight::partly;
            if (sight == Sight::hidden) {
                // A repeated walk leaves out what is not hidden, or was counted before.
                c.occlusion_culled += !map->is_repeated();
                continue;
            }
            const GroupAt group = walker.groups[i];
            // Groups follow each other: most lie in lines that were asked for already.
            if (group.block != asked.block || group.slot / kLineNodes != asked.slot / kLineNodes)
                model.prefetch(asked = group);
            push(opening_of(chunk, k, group, nodes[0].level, sight == Sight::partly),
                 glm::dvec3(chunk.offset[0][k], chunk.offset[1][k], chunk.offset[2][k]));
        }
    }

    void check_groups(std::span<const Opening> nodes, const BlockView& block) const;
    GroupAt group_of(BlockView& block, uint32_t slot) const;
    static Opening opening_of(const Chunk& chunk, size_t k, const GroupAt& group, uint16_t parent_level,
                              bool may_hide);
    Opening root_opening(const CutView& v) const;
    static void count_side_tests(std::span<const Opening> nodes, CutCounts& c);
    void cut(std::span<const Opening> nodes, Walker& walker, BlockView& block, geom::SplatBatch& batch,
             CutCounts& c);
    void find_groups(Walker& walker, BlockView& block) const;
    bool mark_missing(std::span<const Opening> nodes, Walker& walker, const BlockView& block) const;
    void number_waiting(uint32_t level, Walker& walker, BlockView& block, int first, geom::SplatBatch& batch);
    void add_triangles(Walker& walker, const BlockView& block, CutCounts& c);

    // ---- levels, cut_walk.cpp

    Walker& begin_walk();
    void walk_top();
    void narrow_to_raster();
    // As many nodes from the first on as a chunk takes.
    static std::span<const Opening> first_chunk(std::span<const Opening> nodes);
    void walk_level(Walker& walker, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c);
    void walk_task(size_t task, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c);

    // ---- outlines, cut_outline.cpp

    void add_sphere(const glm::vec3& at, float radius, geom::OcclusionMap::Spheres& spheres) const {
        spheres.add(view.in_view(at), radius * (1.0f + kSlack) * view.unit);
    }
    void look_at_opened(Walker& walker, geom::OcclusionMap& map) const;
    void sift(Outline& outline, geom::OcclusionMap& map) const;
    void start_from(Outline& outline, Walker& walker, geom::OcclusionMap* map, CutCounts& c) const;
    bool is_coarse(const std::vector<Opening>& level, float most_px) const;
    void outline(size_t task, geom::OcclusionMap& map, CutCounts& c);
    void show(const Outline& outline, std::vector<geom::OcclusionMap::Surface>& surfaces,
              geom::OcclusionMap& map) const;

    // ---- profiles, cut_profile_walk.cpp

    struct ProfiledLevel;
    void profile_nodes(std::span<const Opening> nodes, const int* steps, double weight, const CutView& v,
                       Walker& walker, CutProfile& profile, ProfiledLevel& next);
    CutProfile profile(const CutView& v, const ProfileOptions& options, uint64_t pixels);
    static double thin_out(ProfiledLevel& level, double weight, CutProfile& profile,
                           const ProfileOptions& options);
};

}  // namespace splat
