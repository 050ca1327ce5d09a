#include "splat/cut/cut_triangles.h"

namespace splat {

namespace {

uint32_t colour_of(const Chunk& chunk, size_t lane, const CutView& view) {
    if (view.last_number) return 0;
    if (!view.has_colour) return view.colour;
    const glm::u8vec3 rgb = decode_colour(uint16_t(chunk.colour[lane]));
    return uint32_t(rgb.r) | uint32_t(rgb.g) << 8 | uint32_t(rgb.b) << 16;
}

}  // namespace

void CutTriangles::add(const Model& model, const BlockView& block, const Chunk& chunk, const CutView& view,
                       const std::function<void(uint64_t)>& touch) {
    const BlockTriangles& triangles = open(model, block);
    for (uint32_t i = 0; i < chunk.triangle_count; ++i) {
        const size_t lane = chunk.triangles[i];
        const BlockTriangles::Place at = triangles.find(chunk.slot[lane]);
        if (at.run == BlockTriangles::Place::kNone)
            model.fault(block.number(), "has leaves without triangles");
        const BlockTriangles::PlacedRun& placed = triangles.runs()[at.run];
        if (seen_block_ != block.number() || seen_run_ != at.run) {
            seen_block_ = block.number(), seen_run_ = at.run;
            seen_.see(placed.run, view);
            for (uint64_t b = placed.first_block; b < placed.end_block; ++b) touch(b);
        }
        seen_.add(placed.run, at.triangle, colour_of(chunk, lane, view), batch);
    }
}

}  // namespace splat
