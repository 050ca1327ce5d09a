#include "splat/triangle_reader.h"

#include "core/error.h"

namespace splat {

void BlockTriangles::open(const Model& model, const BlockView& nodes) {
    is_open_ = false;
    number_ = nodes.number();
    leaf_of_.resize(nodes.node_count());
    leaf_count_ = 0;
    for (uint32_t slot = 0; slot < nodes.node_count(); ++slot) {
        leaf_of_[slot] = uint16_t(leaf_count_);
        leaf_count_ += nodes.children_of(slot) == 0;
    }
    runs_.clear();
    const Header& h = model.header();
    uint64_t block = nodes.triangles_at() / h.block_size;
    auto offset = uint32_t(nodes.triangles_at() % h.block_size);
    for (uint32_t leaf = 0; leaf < leaf_count_;) {
        if (block >= h.block_count) model.fault(number_, "its triangles are beyond the last block");
        if (block >= model.blocks_present()) break;
        const std::span<const std::byte> used = model.triangle_block(block);
        if (offset < kRunsAt)
            model.fault(number_, core::text("its triangles begin at byte %u of a block", offset));
        PlacedRun& placed = runs_.emplace_back();
        placed.block = block, placed.offset = offset, placed.first_leaf = leaf;
        std::string what = placed.run.open(used, offset, h.lattice_bits);
        if (what.empty()) what = placed.run.read_entries(placed.entries);
        if (!what.empty()) model.fault(block, what);
        leaf += placed.run.triangles();
        offset += uint32_t(placed.run.size_bytes());
        if (offset == used.size()) ++block, offset = kRunsAt;
        if (leaf > leaf_count_)
            model.fault(number_, core::text("%u leaves, its runs have %u triangles", leaf_count_, leaf));
    }
    is_open_ = true;
}

}  // namespace splat
