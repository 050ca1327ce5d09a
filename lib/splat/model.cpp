#include "splat/model.h"

#include <cstring>

#include "core/error.h"

namespace splat {

Model::Model(const std::string& path) : Model(core::InputFile(path)) {}

Model::Model(core::InputFile file)
    : file_(std::move(file)), header_(parse_header(file_.bytes(), file_.name())), layout_(header_) {
    const uint64_t whole = (file_.bytes().size() - kHeaderSize) / header_.block_size;
    if (whole > header_.block_count || file_.bytes().size() > kHeaderSize + header_.block_count * header_.block_size)
        throw core::Error(core::text("%s: %zu bytes, its header says %llu", file_.name().c_str(), file_.bytes().size(),
                                     static_cast<unsigned long long>(kHeaderSize + header_.block_count * header_.block_size)));
    if (whole == 0)
        throw core::Error(core::text("%s: cut off at byte %zu, before the end of the first block", file_.name().c_str(),
                                     file_.bytes().size()));
    blocks_present_ = whole;
    checked_ = std::make_unique<std::atomic<uint8_t>[]>(whole);
}

Node Model::root() const {
    Node root;
    root.normal = header_.root_normal;
    root.flatness = header_.root_flatness;
    root.error = header_.root_error;
    root.cone = header_.root_cone;
    root.children = int(header_.root_children);
    root.colour = encode_colour({header_.colour[0], header_.colour[1], header_.colour[2]});
    return root;
}

void Model::fault(uint64_t number, const std::string& what) const {
    throw core::Error(core::text("%s: block %llu at byte %llu: %s", name().c_str(), static_cast<unsigned long long>(number),
                                 static_cast<unsigned long long>(kHeaderSize + number * header_.block_size), what.c_str()));
}

std::span<const std::byte> Model::block(uint64_t number) const {
    if (!has_block(number)) fault(number, number < blocks_present_ ? "is no block of nodes" : "is not there");
    if (checked_[number].load(std::memory_order_acquire) == 0) check_block(number);
    return file_.bytes().subspan(kHeaderSize + number * header_.block_size, header_.block_size);
}

std::span<const std::byte> Model::triangle_block(uint64_t number) const {
    if (number < header_.node_blocks() || number >= blocks_present_)
        fault(number, number < blocks_present_ ? "is no block of triangles" : "is not there");
    if (checked_[number].load(std::memory_order_acquire) == 0) check_block(number);
    const auto bytes = file_.bytes().subspan(kHeaderSize + number * header_.block_size, header_.block_size);
    TriangleBlockHeader head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    return bytes.first(head.used);
}

void Model::prefetch(const GroupAt& group) const {
    if (!has_block(group.block)) return;
    const std::byte* block = file_.bytes().data() + kHeaderSize + group.block * header_.block_size;
    __builtin_prefetch(block);
    __builtin_prefetch(block + layout_.attitude + 2 * group.slot);
    __builtin_prefetch(block + layout_.place + 2 * group.slot);
    __builtin_prefetch(block + layout_.shape + group.slot / 2);
    if (header_.has_colour()) __builtin_prefetch(block + layout_.colour + 2 * group.slot);
}

void Model::check_block(uint64_t number) const {
    const auto bytes = file_.bytes().subspan(kHeaderSize + number * header_.block_size, header_.block_size);
    uint32_t stored;
    std::memcpy(&stored, bytes.data(), sizeof(stored));
    const uint32_t found = block_checksum(bytes, number);
    if (found != stored) fault(number, core::text("checksum %08x, stored is %08x", found, stored));
    if (number < header_.node_blocks())
        check_nodes(number, bytes);
    else
        check_triangles(number, bytes);
    if (checked_[number].exchange(1, std::memory_order_acq_rel) == 0) blocks_used_.fetch_add(1, std::memory_order_relaxed);
}

void Model::check_nodes(uint64_t number, std::span<const std::byte> bytes) const {
    BlockHeader head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    if (head.node_count == 0 || head.node_count > layout_.capacity)
        fault(number, core::text("%u nodes, 1 to %u are possible", head.node_count, layout_.capacity));
    if (head.child_slot >= layout_.capacity)
        fault(number, core::text("child slot %u of %u", head.child_slot, layout_.capacity));
    // Children stand after their parents: this is what makes every walk end.
    if (head.child_block < number) fault(number, "points backwards");
}

void Model::check_triangles(uint64_t number, std::span<const std::byte> bytes) const {
    TriangleBlockHeader head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    if (head.used <= sizeof(head) || head.used > header_.block_size)
        fault(number, core::text("%u bytes in use, %zu to %u are possible", head.used, sizeof(head) + 1, header_.block_size));
}

void BlockView::open(const Model& model, uint64_t number) {
    const std::byte* bytes = model.block(number).data();
    const BlockLayout& layout = model.layout();
    BlockHeader head;
    std::memcpy(&head, bytes, sizeof(head));
    number_ = number;
    is_open_ = true;
    node_count_ = head.node_count;
    child_block_ = head.child_block;
    attitude_ = reinterpret_cast<const uint16_t*>(bytes + layout.attitude);
    place_ = reinterpret_cast<const uint16_t*>(bytes + layout.place);
    shape_ = reinterpret_cast<const uint8_t*>(bytes + layout.shape);
    colour_ = model.header().has_colour() ? reinterpret_cast<const uint16_t*>(bytes + layout.colour) : nullptr;
    child_slot_ = head.child_slot;
    if (model.header().has_triangles()) std::memcpy(&triangles_at_, bytes + kBlockTrianglesAt, sizeof(triangles_at_));
    capacity_ = layout.capacity;
    counted_ = 0;
    child_at_ = {child_block_, child_slot_};
}

}  // namespace splat
