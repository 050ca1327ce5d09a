#include "splat/model.h"

#include <algorithm>
#include <cstring>

#include "core/error.h"

namespace splat {

Model::Model(const std::string& path) : Model(core::InputFile(path)) {}

namespace {

uint64_t whole_plain_blocks(const core::InputFile& file, const Header& header) {
    const uint64_t whole = (file.bytes().size() - kHeaderSize) / header.block_size;
    if (whole > header.block_count || file.bytes().size() > kHeaderSize + header.block_count * header.block_size)
        throw core::Error(core::text("%s: %zu bytes, its header says %llu", file.name().c_str(), file.bytes().size(),
                                     static_cast<unsigned long long>(kHeaderSize + header.block_count * header.block_size)));
    return whole;
}

}  // namespace

Model::Model(core::InputFile file)
    : file_(std::move(file)), header_(parse_header(file_.bytes(), file_.name())), layout_(header_) {
    if (is_coded(file_.bytes())) {
        coded_ = std::make_unique<CodedFile>(file_.bytes(), file_.name());
        blocks_present_ = coded_->count_present();
        own_ = core::AddressSpace(blocks_present_ * header_.block_size, file_.name());
        blocks_ = own_.bytes().data();
    } else {
        blocks_present_ = whole_plain_blocks(file_, header_);
        blocks_ = file_.bytes().data() + kHeaderSize;
    }
    if (blocks_present_ == 0)
        throw core::Error(core::text("%s: cut off at byte %zu, before the end of the first block", file_.name().c_str(),
                                     file_.bytes().size()));
    checked_ = std::make_unique<std::atomic<uint8_t>[]>(blocks_present_);
}

std::array<std::byte, kHeaderSize> Model::header_bytes() const {
    std::array<std::byte, kHeaderSize> bytes;
    const auto from = coded_ ? coded_->plain_header() : file_.bytes().first(kHeaderSize);
    std::copy(from.begin(), from.end(), bytes.begin());
    return bytes;
}

uint64_t Model::prefix_bytes(uint64_t block) const {
    if (!coded_) return kHeaderSize + (block + 1) * header_.block_size;
    const CodedPlace place = coded_->place_of(block);
    return place.offset + place.size;
}

uint64_t Model::offset_of(uint64_t number) const {
    if (!coded_) return kHeaderSize + number * header_.block_size;
    return number < blocks_present_ ? coded_->place_of(number).offset : size_bytes();
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
                                 static_cast<unsigned long long>(offset_of(number)), what.c_str()));
}

std::span<const std::byte> Model::block(uint64_t number) const {
    if (number >= header_.node_blocks()) fault(number, "is no block of nodes");
    return any_block(number);
}

std::span<const std::byte> Model::any_block(uint64_t number) const {
    if (number >= blocks_present_) fault(number, "is not there");
    if (checked_[number].load(std::memory_order_acquire) == 0) take_block(number);
    return {blocks_ + number * header_.block_size, header_.block_size};
}

std::span<const std::byte> Model::triangle_block(uint64_t number) const {
    if (number < header_.node_blocks()) fault(number, "is no block of triangles");
    return any_block(number);
}

void Model::prefetch(const GroupAt& group) const {
    if (!has_block(group.block)) return;
    const std::byte* block = blocks_ + group.block * header_.block_size;
    __builtin_prefetch(block);
    __builtin_prefetch(block + layout_.attitude + 2 * group.slot);
    __builtin_prefetch(block + layout_.place + 2 * group.slot);
    __builtin_prefetch(block + layout_.shape + group.slot / 2);
    if (header_.has_colour()) __builtin_prefetch(block + layout_.colour + 2 * group.slot);
}

void Model::take_block(uint64_t number) const {
    if (!coded_) return check_block(number);
    const std::lock_guard lock(taking_[number % taking_.size()]);
    if (checked_[number].load(std::memory_order_acquire) != 0) return;
    coded_->read(number, own_block(number));
    check_block(number);
}

void Model::check_block(uint64_t number) const {
    const std::span bytes(blocks_ + number * header_.block_size, header_.block_size);
    uint32_t stored;
    std::memcpy(&stored, bytes.data(), sizeof(stored));
    const uint32_t found = block_checksum(bytes, number);
    if (found != stored) fault(number, core::text("checksum %08x, stored is %08x", found, stored));
    if (number < header_.node_blocks()) check_nodes(number, bytes);
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
    if (model.header().has_triangles()) {
        std::memcpy(&triangles_at_, bytes + kBlockTrianglesAt, sizeof(triangles_at_));
        std::memcpy(&middle_side_, bytes + kBlockMiddleSideAt, sizeof(middle_side_));
    }
    capacity_ = layout.capacity;
    counted_ = 0;
    child_at_ = {child_block_, child_slot_};
}

}  // namespace splat
