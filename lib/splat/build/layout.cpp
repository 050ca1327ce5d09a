#include "splat/build/layout.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "core/parallel.h"

namespace splat {

namespace {

constexpr uint32_t kUpper = 0xffffffffu;

// A sibling group on its way into the file.
struct QueuedGroup {
    uint32_t tree, group;
    uint64_t block = 0;
    uint32_t slot = 0;
};

// A coded node: the root of a subtree stands in the upper tree's group.
struct NodeAt {
    uint32_t tree;
    size_t node;
};

class Layout {
  public:
    Layout(const CodedModel& model, Header& header) : model_(model), header_(header), layout_(header) {}

    void write(const TriangleSource* triangles, core::OutputFile& out) {
        queue_groups();
        std::optional<TriangleBlocks> triangle_blocks;
        if (triangles) {
            triangle_blocks.emplace(
                *triangles, header_.block_size, header_.block_count,
                [&](uint64_t b, std::vector<uint32_t>& leaves) { list_leaves(b, leaves); });
            header_.triangle_blocks = triangle_blocks->count();
            header_.block_count += header_.triangle_blocks;
        }
        out.write(encode_header(header_));
        out.write(kGap);
        constexpr uint64_t kBatch = 4096;  // blocks held in memory
        std::vector<std::byte> bytes;
        for (uint64_t first = 0; first < header_.node_blocks(); first += kBatch) {
            const uint64_t count = std::min(kBatch, header_.node_blocks() - first);
            bytes.assign(count * header_.block_size, std::byte{0});
            core::parallel_for(
                count,
                [&](size_t b) {
                    const auto block = std::span(bytes).subspan(b * header_.block_size, header_.block_size);
                    if (triangle_blocks) {
                        const uint64_t at = triangle_blocks->at(first + b);
                        std::memcpy(block.data() + kBlockTrianglesAt, &at, sizeof(at));
                        const float side = triangle_blocks->middle_side(first + b);
                        std::memcpy(block.data() + kBlockMiddleSideAt, &side, sizeof(side));
                    }
                    fill_block(first + b, block);
                },
                64);
            out.write(bytes);
        }
        if (triangle_blocks) triangle_blocks->write(out);
    }

  private:
    const CodedTree& tree(uint32_t t) const { return t == kUpper ? model_.upper : model_.subtrees[t]; }

    NodeAt node_at(uint32_t t, size_t node) const {
        if (t == kUpper && model_.upper.child_group[node] <= -2)
            return {uint32_t(-2 - model_.upper.child_group[node]), 0};
        return {t, node};
    }

    // First in, first out: this is the order of the file.  A group that does not fit whole begins the
    // next block.
    void queue_groups() {
        queue_.push_back({kUpper, 0});
        uint64_t block = 0;
        uint32_t slot = 0;
        size_t level_end = 1;
        header_.level_count = 0, header_.node_count = 0, header_.leaf_count = 0;
        block_first_.push_back(0);
        for (size_t q = 0; q < queue_.size(); ++q) {
            if (q == level_end) level_end = queue_.size(), ++header_.level_count;
            const QueuedGroup at = queue_[q];
            const auto [first, count] = tree(at.tree).groups[at.group];
            if (slot + count > layout_.capacity) {
                ++block, slot = 0;
                block_first_.push_back(q);
            }
            queue_[q].block = block, queue_[q].slot = slot;
            slot += count;
            for (uint32_t k = 0; k < count; ++k) {
                const NodeAt node = node_at(at.tree, first + k);
                const int32_t children = tree(node.tree).child_group[node.node];
                ++header_.node_count;
                if (children == CodedTree::kLeaf)
                    ++header_.leaf_count;
                else
                    queue_.push_back({node.tree, uint32_t(children)});
            }
            if (q + 1 == queue_.size()) break;
        }
        ++header_.level_count;
        header_.block_count = block + 1;
        header_.root_children = model_.upper.groups[0].count;
        first_children();
    }

    // For each block, the queue position of its nodes' first child group: the queue is in order, so it
    // follows from how many groups were pushed before.
    void first_children() {
        size_t pushed = 1;
        for (size_t b = 0; b < block_first_.size(); ++b) {
            block_child_.push_back(pushed);
            for (size_t q = block_first_[b]; q < block_end(b); ++q) {
                const auto [first, count] = tree(queue_[q].tree).groups[queue_[q].group];
                for (uint32_t k = 0; k < count; ++k) {
                    const NodeAt node = node_at(queue_[q].tree, first + k);
                    pushed += tree(node.tree).child_group[node.node] != CodedTree::kLeaf;
                }
            }
        }
    }

    size_t block_end(size_t b) const {
        return b + 1 < block_first_.size() ? block_first_[b + 1] : queue_.size();
    }

    // Appends the numbers of the block's leaves that are triangles, in the order of their slots.
    void list_leaves(uint64_t b, std::vector<uint32_t>& leaves) const {
        for (size_t q = block_first_[b]; q < block_end(b); ++q) {
            const auto [first, count] = tree(queue_[q].tree).groups[queue_[q].group];
            for (uint32_t k = 0; k < count; ++k) {
                const NodeAt at = node_at(queue_[q].tree, first + k);
                const CodedTree& t = tree(at.tree);
                if (t.child_group[at.node] == CodedTree::kLeaf) leaves.push_back(t.leaf[at.node]);
            }
        }
    }

    void fill_block(uint64_t b, std::span<std::byte> bytes) const {
        BlockHeader head{};
        const auto put16 = [&](size_t channel, uint32_t slot, uint16_t value) {
            std::memcpy(bytes.data() + channel + 2 * size_t(slot), &value, 2);
        };
        for (size_t q = block_first_[b]; q < block_end(b); ++q) {
            const auto [first, count] = tree(queue_[q].tree).groups[queue_[q].group];
            for (uint32_t k = 0; k < count; ++k) {
                const NodeAt at = node_at(queue_[q].tree, first + k);
                const CodedTree& t = tree(at.tree);
                const uint32_t slot = queue_[q].slot + k;
                put16(layout_.attitude, slot, t.attitude[at.node]);
                put16(layout_.place, slot, t.place[at.node]);
                if (header_.has_colour()) put16(layout_.colour, slot, t.colour[at.node]);
                bytes[layout_.shape + slot / 2] |= std::byte(t.shape[at.node] << (slot & 1 ? 4 : 0));
                head.node_count = uint16_t(slot + 1);
            }
        }
        const size_t child = block_child_[b];
        const bool has_children = child < queue_.size();
        head.child_block = has_children ? queue_[child].block : b;
        head.child_slot = uint16_t(has_children ? queue_[child].slot : 0);
        std::memcpy(bytes.data(), &head, sizeof(head));
        head.checksum = block_checksum(bytes, b);
        std::memcpy(bytes.data(), &head, sizeof(head));
    }

    const CodedModel& model_;
    Header& header_;
    const BlockLayout layout_;
    std::vector<QueuedGroup> queue_;
    std::vector<size_t> block_first_, block_child_;  // queue positions
};

}  // namespace

void write_model(const CodedModel& model, const TriangleSource* triangles, Header& header,
                 core::OutputFile& out) {
    Layout(model, header).write(triangles, out);
}

}  // namespace splat
