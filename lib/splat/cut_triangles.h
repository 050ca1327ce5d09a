// Leaves that are handed out as triangles: their corners, decoded once a run and view.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "geom/triangle_batch.h"
#include "splat/cut_groups.h"
#include "splat/triangle_reader.h"

namespace splat {

// What a thread keeps between tasks and frames.
class CutTriangles {
  public:
    geom::TriangleBatch batch;

    // Nothing is in the batch any more, and no run is decoded for another view.
    void begin() { batch.count = 0, run_.block = ~uint64_t(0); }

    const BlockTriangles& open(const Model& model, const BlockView& block) {
        BlockTriangles& found = opened_[block.number() % kOpened];
        if (!found.is_open() || found.number() != block.number()) found.open(model, block);
        return found;
    }

    // Appends the chunk's triangles to the batch, which has room for them.  `touch` is told of the blocks of
    // triangles that are used.
    void add(const Model& model, const BlockView& block, const Chunk& chunk, const CutView& view,
             const std::function<void(uint64_t)>& touch);

  private:
    static constexpr size_t kOpened = 16;

    // The corners of a run in view space, each decoded when it is first asked for.
    struct DecodedRun {
        uint64_t block = ~uint64_t(0);  // of nodes
        uint32_t run = 0;
        std::vector<uint8_t> is_decoded;
        std::vector<glm::vec3> at, normal;
    };

    void decode_corner(const TriangleRun& run, uint32_t entry, const CutView& view);
    void add_triangle(const BlockTriangles::PlacedRun& placed, uint32_t triangle, uint32_t colour,
                      const CutView& view);

    std::array<BlockTriangles, kOpened> opened_;  // by number modulo this
    DecodedRun run_;
};

}  // namespace splat
