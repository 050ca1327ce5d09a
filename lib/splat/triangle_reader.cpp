#include "splat/triangle_reader.h"

#include <algorithm>
#include <cstring>

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
    run_count_ = 0;
    lacks_.reset();
    stock_ = model.stock();
    const Header& h = model.header();
    uint64_t at = nodes.triangles_at();
    for (uint32_t leaf = 0; leaf < leaf_count_;) {
        if (!gather(model, at, kRunSizeBytes)) break;
        const size_t size = TriangleRun::size_of(std::span<const std::byte>(bytes_).first<kRunSizeBytes>());
        if (size < kRunSizeBytes) model.fault(number_, core::text("a run of %zu bytes", size));
        if (!gather(model, at, size)) break;
        if (runs_.size() == run_count_) runs_.emplace_back();
        PlacedRun& placed = runs_[run_count_++];
        placed.at = at, placed.first_leaf = leaf;
        placed.first_block = h.node_blocks() + at / h.triangle_payload();
        placed.end_block = h.node_blocks() + (at + size - 1) / h.triangle_payload() + 1;
        const std::string what = placed.run.read(std::span(bytes_).first(size), h.lattice_bits);
        if (!what.empty()) model.fault(placed.first_block, what);
        leaf += placed.run.triangles(), at += size;
        if (leaf > leaf_count_)
            model.fault(number_, core::text("%u leaves, its runs have %u triangles", leaf_count_, leaf));
    }
    is_open_ = true;
}

// Takes bytes of runs into bytes_.  False where they are not all there.
bool BlockTriangles::gather(const Model& model, uint64_t at, size_t count) {
    const Header& h = model.header();
    const uint64_t payload = h.triangle_payload();
    if (at > h.triangle_blocks * payload || count > h.triangle_blocks * payload - at)
        model.fault(number_, "its triangles are beyond the last block");
    bytes_.resize(count + kRunReadAhead);
    for (size_t done = 0; done < count;) {
        const uint64_t block = h.node_blocks() + (at + done) / payload, from = (at + done) % payload;
        if (!model.is_there(block)) {
            lacks_ = block;
            return false;
        }
        const size_t part = std::min<size_t>(count - done, payload - from);
        std::memcpy(bytes_.data() + done, model.triangle_block(block).data() + kTriangleBlockHeader + from,
                    part);
        done += part;
    }
    return true;
}

}  // namespace splat
