// The walk over a sample of the nodes that tells what cuts of other thresholds would hold.
#include <algorithm>

#include "splat/cut/cut_walk.h"

namespace splat {

// Nodes to be opened in a walk that profiles: at thresholds before `steps` of the profile.
struct Cut::State::ProfiledLevel {
    std::vector<Opening> nodes;
    std::vector<int> steps;

    void clear() { nodes.clear(), steps.clear(); }
    void keep(size_t from, size_t to) { nodes[to] = nodes[from], steps[to] = steps[from]; }
    void shorten(size_t count) { nodes.resize(count), steps.resize(count); }
};

// Opens nodes whose groups lie in one block.  What they hold counts `weight` times.
void Cut::State::profile_nodes(std::span<const Opening> nodes, const int* steps, double weight,
                               const CutView& v, Walker& walker, CutProfile& profile, ProfiledLevel& next) {
    const uint64_t number = nodes[0].block;
    // Not by whether the block was checked: walks of this kind check some blocks, too.
    const bool is_cold = touched(number).load(std::memory_order_relaxed) == 0;
    BlockView& block = walker.open_block(model, number);
    check_groups(nodes, block);
    Chunk& chunk = walker.chunk;
    chunk.missing.fill(0);
    CutCounts unused;
    cut_groups(nodes, block, v, chunk, walker.batch, unused);
    size_t g = 0;
    for (uint32_t i = 0, end = nodes[0].children; i < chunk.open_count; ++i) {
        const size_t k = chunk.open[i];
        while (k >= end) end += nodes[++g].children;
        const bool is_leaf = (chunk.code[k] & 7) == 0;
        const GroupAt group = is_leaf ? GroupAt{} : group_of(block, chunk.slot[k]);
        const bool ends = is_leaf || !model.has_block(group.block);
        const int drawn_from = ends ? 0 : profile.step_of(double(chunk.needed[k]));
        profile.add_splat(drawn_from, steps[g], double(chunk.size[k]), weight);
        if (const int opened = std::min(drawn_from, steps[g]); opened > 0)
            next.nodes.push_back(opening_of(chunk, k, group, nodes[0].level, false)),
                next.steps.push_back(opened);
    }
    for (size_t n = 0; n < nodes.size(); ++n)
        profile.add_nodes(steps[n], weight * double(nodes[n].children), is_cold);
}

CutProfile Cut::State::profile(const CutView& v, const ProfileOptions& options, uint64_t pixels) {
    CutProfile profile(options, pixels);
    Walker& walker = begin_walk();
    ProfiledLevel level, next;
    level.nodes.push_back(root_opening(v)), level.steps.push_back(CutProfile::kSteps);
    double weight = 1;
    while (!level.nodes.empty()) {
        next.clear();
        for (std::span<const Opening> rest = level.nodes, nodes; !rest.empty();
             rest = rest.subspan(nodes.size())) {
            nodes = first_chunk(rest);
            const int* steps = level.steps.data() + (nodes.data() - level.nodes.data());
            profile_nodes(nodes, steps, weight, v, walker, profile, next);
        }
        weight = thin_out(next, weight, profile, options);
        for (const Opening& node : next.nodes) model.prefetch({node.block, node.slot});
        std::swap(level, next);
    }
    profile.finish();
    return profile;
}

// Leaves out nodes that only cuts beyond the limit open, and of the others all but every n-th.  Returns
// the weight of those that are left.
double Cut::State::thin_out(ProfiledLevel& level, double weight, CutProfile& profile,
                            const ProfileOptions& options) {
    profile.limit(level.steps, weight);
    size_t kept = 0;
    for (size_t i = 0; i < level.nodes.size(); ++i)
        if (level.steps[i] > profile.first_step()) level.keep(i, kept++);
    const size_t stride = (kept + options.samples - 1) / options.samples;
    if (stride > 1) {
        size_t sampled = 0;
        for (size_t i = stride / 2; i < kept; i += stride) level.keep(i, sampled++);
        weight *= double(kept) / double(sampled);
        kept = sampled;
    }
    level.shorten(kept);
    return weight;
}

}  // namespace splat
