// The part of the walk that shows an occlusion map what it is about to draw.
#include <algorithm>

#include "splat/cut/cut_walk.h"

namespace splat {

namespace {

// Levels are outlined until half of their nodes are smaller than this.  The first outline tells whether there
// is much to hide, for 1 % of the dragon's frame (100 px: 2 %); the second hides two to five times as much.
// 40 px alone would hide a twentieth more, and cost frames with nothing to hide 8 %.
constexpr float kOutlinePx[] = {140, 40};
static_assert(std::size(kOutlinePx) == kOutlines);

}  // namespace

// Into the walker's sights.  Nodes whose parents were clear are so, too.
void Cut::State::look_at_opened(Walker& walker, geom::OcclusionMap& map) const {
    const Chunk& chunk = walker.chunk;
    std::array<uint32_t, Chunk::kNodes> looked_at;
    walker.spheres.count = 0;
    for (uint32_t i = 0; i < chunk.open_count; ++i) {
        walker.sights[i] = Sight::clear;
        const size_t k = chunk.open[i];
        if (!(chunk.shape[k] & Chunk::kParentMayHide)) continue;
        looked_at[walker.spheres.count] = i;
        add_sphere({chunk.at[0][k], chunk.at[1][k], chunk.at[2][k]}, chunk.radius[k], walker.spheres);
    }
    if (walker.spheres.count == 0) return;
    std::array<Sight, Chunk::kNodes> sights;
    map.look(walker.spheres, sights.data());
    for (size_t n = 0; n < walker.spheres.count; ++n) walker.sights[looked_at[n]] = sights[n];
}

// Finds the sights of the outline's level.
void Cut::State::sift(Outline& outline, geom::OcclusionMap& map) const {
    using Spheres = geom::OcclusionMap::Spheres;
    Spheres spheres;
    outline.sights.resize(outline.level.size());
    for (size_t first = 0; first < outline.level.size(); first += spheres.count) {
        const size_t count = std::min(Spheres::kCapacity, outline.level.size() - first);
        spheres.count = 0;
        for (size_t i = first; i < first + count; ++i)
            add_sphere(outline.level[i].at, outline.level[i].radius, spheres);
        map.look(spheres, &outline.sights[first]);
    }
}

void Cut::State::start_from(Outline& outline, Walker& walker, geom::OcclusionMap* map, CutCounts& c) const {
    walker.level.clear();
    if (map && map->is_repeated()) sift(outline, *map);
    for (size_t i = 0; i < outline.level.size(); ++i) {
        const Opening& node = outline.level[i];
        const Sight sight = map ? outline.sights[i] : Sight::partly;
        c.occlusion_culled += sight == Sight::hidden && !map->is_repeated();
        if (sight == Sight::hidden) continue;
        walker.level.push_back(node);
        walker.level.back().may_hide = sight == Sight::partly;
    }
}

bool Cut::State::is_coarse(const std::vector<Opening>& level, float most_px) const {
    const auto is_wide = [&](const Opening& node) {
        return 2 * node.radius * view.focal > most_px * (glm::dot(view.forward, node.at) + view.pivot_depth);
    };
    return 2 * size_t(std::count_if(level.begin(), level.end(), is_wide)) > level.size();
}

void Cut::State::outline(size_t task, geom::OcclusionMap& map, CutCounts& c) {
    Walker& walker = begin_walk();
    TaskOutlines& made = outlines[task];
    if (made.count == 0)
        walker.level.assign(1, tasks[task]);
    else
        start_from(made.last(), walker, &map, c);
    const float most_px = kOutlinePx[made.count++];
    Outline& outline = made.last();
    outline.splats.clear(), outline.triangles.clear();
    const Sink keep = [&](const geom::SplatBatch& batch) { outline.keep(batch); };
    const TriangleSink keep_triangles = [&](const geom::TriangleBatch& batch) {
        outline.triangles.push_back(batch);
    };
    while (is_coarse(walker.level, most_px)) walk_level(walker, {keep, keep_triangles}, nullptr, c);
    empty(walker.batch, keep), empty(walker.triangles.batch, keep_triangles);
    outline.level.assign(walker.level.begin(), walker.level.end());
    show(outline, walker.surfaces, map);
}

void Cut::State::show(const Outline& outline, std::vector<geom::OcclusionMap::Surface>& surfaces,
                      geom::OcclusionMap& map) const {
    surfaces.clear();
    for (const Opening& node : outline.level) {
        const glm::vec3 centre = view.in_view(node.at), normal = view.turned(node.normal);
        if (view.cull_backfaces && glm::dot(normal, centre) > 0) continue;
        // A surface that bends by the cone's half-angle is off its disc by about half the sine.
        const float radius = node.radius * view.unit;
        const float bend = node.cone < 0 ? 2.0f : 0.5f * kConeSin[node.cone];
        surfaces.push_back({centre, radius, normal, bend * radius});
    }
    for (const Outline::Splat& s : outline.splats)
        surfaces.push_back({{s.x, s.y, s.z}, s.radius, {s.nx, s.ny, s.nz}, s.radius * s.flatness});
    map.add_surfaces(surfaces);
}

}  // namespace splat
