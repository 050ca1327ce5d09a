// What outlining a task came to, for the rest of the walk to go on from.
#pragma once

#include <array>
#include <vector>

#include "geom/occlusion.h"
#include "geom/splat_batch.h"
#include "geom/triangle_batch.h"
#include "splat/cut.h"
#include "splat/cut/cut_groups.h"

namespace splat {

constexpr size_t kOutlines = 2;  // at most, of a task in a frame

// Where splats and triangles go.
struct Sinks {
    const Cut::Sink& splats;
    const Cut::TriangleSink& triangles;
};

// What outlining came to: the nodes that wait to be opened, and the splats of the levels above them.
struct Outline {
    struct Splat {
        float x, y, z, radius, nx, ny, nz, flatness;
        uint32_t colour;
    };
    std::vector<Opening> level;
    std::vector<Splat> splats;
    std::vector<geom::TriangleBatch> triangles;
    std::vector<geom::OcclusionMap::Sight> sights;  // of the level, once it is sifted

    void keep(const geom::SplatBatch& b) {
        for (int i = 0; i < b.count; ++i)
            splats.push_back(
                {b.x[i], b.y[i], b.z[i], b.radius[i], b.nx[i], b.ny[i], b.nz[i], b.flatness[i], b.colour[i]});
    }
    void hand_out(geom::SplatBatch& batch, const Sinks& sinks) const {
        for (const geom::TriangleBatch& kept : triangles) sinks.triangles(kept);
        for (const Splat& s : splats) {
            if (batch.count == geom::SplatBatch::kCapacity) sinks.splats(batch), batch.count = 0;
            const int i = batch.count++;
            batch.x[i] = s.x, batch.y[i] = s.y, batch.z[i] = s.z, batch.radius[i] = s.radius;
            batch.nx[i] = s.nx, batch.ny[i] = s.ny, batch.nz[i] = s.nz, batch.flatness[i] = s.flatness;
            batch.colour[i] = s.colour;
        }
    }
};

// The outlines of a task in this frame, each of what the one before left.
struct TaskOutlines {
    std::array<Outline, kOutlines> of;
    int count = 0;

    Outline& last() { return of[size_t(count - 1)]; }
};

}  // namespace splat
