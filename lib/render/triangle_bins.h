// Sorting triangles into the tiles of the screen as they come.
//
// What is kept of a triangle is one cache line, and for each tile it may lie in a pointer to that: triangles
// are larger than splats, and many lie in several tiles.  Several threads have bins of their own, which they
// lend to one task at a time, as they do with TileBins; what a task put into them stays until the next frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "geom/triangle_batch.h"
#include "render/splat_record.h"

namespace render {

// A triangle as it came, but for its normals.
struct alignas(64) PackedTriangle {
    float corners[3][4];      // x, y, z, and the normal there: octahedral_codes() of octahedral-inl.h
    uint16_t x0, y0, x1, y1;  // pixels of the picture whose centres may be inside, inclusive
    uint32_t colour;          // 0x00BBGGRR
};
static_assert(sizeof(PackedTriangle) == 64);

// Those that may lie in `tile`, tiles being counted row by row.
struct TriangleRun {
    uint32_t tile, count;
    const PackedTriangle* const* triangles;
};

// Memory that is handed out in pieces, and taken back all at once.
template <class T>
class Arena {
  public:
    void begin() { slab_ = used_ = 0; }

    T* take(size_t count) {
        while (slab_ < slabs_.size() && used_ + count > slabs_[slab_].size) ++slab_, used_ = 0;
        if (slab_ == slabs_.size()) {
            const size_t size = std::max(count, kLeastSlab);
            slabs_.push_back({std::make_unique_for_overwrite<T[]>(size), size});
        }
        used_ += count;
        return &slabs_[slab_].items[used_ - count];
    }

  private:
    static constexpr size_t kLeastSlab = 4096;
    struct Slab {
        std::unique_ptr<T[]> items;
        size_t size;
    };
    std::vector<Slab> slabs_;
    size_t slab_ = 0, used_ = 0;
};

class TriangleBins {
  public:
    // Starts a frame; memory of the last one is used again.
    void begin(int tiles_across, int tiles_down);

    // Takes the triangles that may cover the centre of a pixel.
    void add(const SetupParams& params, const geom::TriangleBatch& batch);

    // Ends a task: `runs` get its triangles, those of a tile in their order.
    void end_task(std::vector<TriangleRun>& runs);

  private:
    struct Entry {
        uint32_t tile;
        const PackedTriangle* triangle;
    };
    void put(const PackedTriangle& triangle, const TileGrid& grid);

    Arena<PackedTriangle> triangles_;
    Arena<const PackedTriangle*> sorted_;
    std::vector<Entry> entries_;  // of the task
    std::vector<uint32_t> ends_;  // of each tile's
};

}  // namespace render
