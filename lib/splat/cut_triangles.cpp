#include "splat/cut_triangles.h"

#include <cmath>

namespace splat {

namespace {

uint32_t colour_of(const Chunk& chunk, size_t lane, const CutView& view) {
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
        if (run_.block != block.number() || run_.run != at.run) {
            run_.block = block.number(), run_.run = at.run;
            run_.is_decoded.assign(placed.run.corners(), false);
            run_.at.resize(placed.run.corners()), run_.normal.resize(placed.run.corners());
            touch(placed.block);
        }
        add_triangle(placed, at.triangle, colour_of(chunk, lane, view), view);
    }
}

void CutTriangles::add_triangle(const BlockTriangles::PlacedRun& placed, uint32_t triangle, uint32_t colour,
                                const CutView& view) {
    const TriangleRun& run = placed.run;
    const glm::u32vec3 entries = placed.entries[triangle];
    for (int k = 0; k < 3; ++k)
        if (!run_.is_decoded[entries[k]]) decode_corner(run, entries[k], view);
    glm::vec3 flat(0);
    const bool is_smooth = run.is_smooth(triangle);
    if (!is_smooth) {
        const glm::dvec3 a(run.position(entries.x));
        const glm::dvec3 n =
            glm::cross(glm::dvec3(run.position(entries.y)) - a, glm::dvec3(run.position(entries.z)) - a);
        const double length = glm::length(n);
        if (!(length > 0)) return;  // without area there is nothing to show
        flat = view.turned(glm::vec3(n / length));
    }
    const int to = batch.count++;
    for (int k = 0; k < 3; ++k) {
        const glm::vec3 &at = run_.at[entries[k]], &n = is_smooth ? run_.normal[entries[k]] : flat;
        batch.x[k][to] = at.x, batch.y[k][to] = at.y, batch.z[k][to] = at.z;
        batch.nx[k][to] = n.x, batch.ny[k][to] = n.y, batch.nz[k][to] = n.z;
    }
    batch.colour[to] = colour;
}

// From its place on the lattice in the same way whatever run it is in, and so to the same bits.
void CutTriangles::decode_corner(const TriangleRun& run, uint32_t entry, const CutView& view) {
    const glm::dvec3 at = glm::dvec3(run.position(entry)) * view.lattice_step;
    run_.at[entry] = view.in_view(glm::vec3(at - view.pivot));
    if (run.has_normals()) run_.normal[entry] = view.turned(decode_corner_normal(run.normal_code(entry)));
    run_.is_decoded[entry] = true;
}

}  // namespace splat
