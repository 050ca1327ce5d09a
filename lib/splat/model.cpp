#include "splat/model.h"

#include <algorithm>
#include <cstring>

#include "core/error.h"

namespace splat {

Model::Model(const std::string& path) : Model(core::InputFile(path, file_bytes)) {}

namespace {

unsigned long long number(uint64_t value) {
    return value;
}

uint64_t whole_plain_blocks(uint64_t file_bytes, const Header& header, const std::string& name) {
    if (file_bytes > header.plain_bytes())
        throw core::Error(core::text("%s: %llu bytes, its header says %llu", name.c_str(), number(file_bytes),
                                     number(header.plain_bytes())));
    return file_bytes < header.block_at(0) ? 0 : (file_bytes - header.block_at(0)) / header.block_size;
}

Header arriving_header(const BlockSource& source) {
    const auto head = [&](uint64_t bytes) {
        bytes = std::min(bytes, source.file_bytes());
        if (!source.has(0, bytes)) throw core::Error(source.name() + ": its header is not there");
        return std::span(source.data(), bytes);
    };
    return parse_header(head(header_extent(head(kCodedHeaderSize))), source.name());
}

std::unique_ptr<CodedFile> arriving_coded_file(const BlockSource& source) {
    const auto is_there = [&source](const CodedPlace& place) { return source.has(place.offset, place.size); };
    auto coded =
        std::make_unique<CodedFile>(std::span(source.data(), source.file_bytes()), is_there, source.name());
    if (source.file_bytes() < coded->file_size())
        throw core::Error(core::text(
            "%s: is cut off at byte %llu of %llu; a compressed file that is can be drawn once it is "
            "here ('qs-fetch get'), and not while it arrives",
            source.name().c_str(), number(source.file_bytes()), number(coded->file_size())));
    return coded;
}

}  // namespace

uint64_t header_extent(std::span<const std::byte> head) {
    return is_coded(head) && head.size() >= kCodedHeaderSize ? coded_header_bytes(head) : kBlocksAt;
}

Model::Model(core::InputFile file)
    : file_(std::move(file)),
      name_(file_->name()),
      header_(parse_header(file_->bytes(), name_)),
      layout_(header_) {
    if (is_coded(file_->bytes())) {
        coded_ = std::make_unique<CodedFile>(file_->bytes(), file_->name());
        take_coded(coded_->count_present());
    } else {
        blocks_present_ = whole_plain_blocks(file_->bytes().size(), header_, name_);
        blocks_ = file_->bytes().data() + header_.block_at(0);
    }
    make_room_for_blocks();
}

Model::Model(std::unique_ptr<const BlockSource> source)
    : source_(std::move(source)),
      name_(source_->name()),
      header_(arriving_header(*source_)),
      layout_(header_) {
    if (is_coded({source_->data(), kHeaderSize})) {
        coded_ = arriving_coded_file(*source_);
        take_coded(header_.block_count);
    } else {
        blocks_present_ = whole_plain_blocks(source_->file_bytes(), header_, name_);
        blocks_ = source_->data() + header_.block_at(0);
    }
    make_room_for_blocks();
    looked_for_ = core::AddressSpace(blocks_present_ * sizeof(uint32_t), name_);
}

void Model::take_coded(uint64_t blocks_present) {
    blocks_present_ = blocks_present;
    own_ = core::AddressSpace(blocks_present_ * header_.block_size, name_);
    blocks_ = own_.bytes().data();
}

void Model::make_room_for_blocks() {
    if (blocks_present_ == 0)
        throw core::Error(core::text("%s: cut off at byte %zu, before the end of the first block",
                                     name_.c_str(), size_bytes()));
    checked_ = core::AddressSpace(blocks_present_, name_);
}

// Whoever looks first decides for all, so that a frame has one answer.
bool Model::look_for(uint64_t number) const {
    const uint32_t there = stock_ << 1 | uint32_t(has_arrived(number));
    const auto known = stock_of(number);
    uint32_t before = known.load(std::memory_order_acquire);
    while (before >> 1 != stock_)
        if (known.compare_exchange_weak(before, there, std::memory_order_acq_rel)) before = there;
    return before & 1;
}

// What was decoded stays, whatever becomes of the bytes that it came from.
bool Model::has_arrived(uint64_t number) const {
    if (coded_ && checked(number).load(std::memory_order_acquire) != 0) return true;
    const FoundPlace next = next_bytes(number);
    return next.is_block && source_->has(next.place.offset, next.place.size);
}

FoundPlace Model::next_bytes(uint64_t block) const {
    return coded_ ? coded_->look_up(block) : FoundPlace{{header_.block_at(block), header_.block_size}, true};
}

uint64_t Model::mean_block_bytes() const {
    return coded_ ? (coded_->file_size() - coded_->header_size()) / header_.block_count : header_.block_size;
}

std::array<std::byte, kHeaderSize> Model::header_bytes() const {
    std::array<std::byte, kHeaderSize> bytes;
    const std::byte* const from = coded_    ? coded_->plain_header().data()
                                  : source_ ? source_->data()
                                            : file_->bytes().data();
    std::copy_n(from, kHeaderSize, bytes.begin());
    return bytes;
}

uint64_t Model::prefix_bytes(uint64_t block) const {
    if (!coded_) return header_.block_at(block + 1);
    const CodedPlace place = coded_->place_of(block);
    return place.offset + place.size;
}

uint64_t Model::offset_of(uint64_t number) const {
    if (!coded_) return header_.block_at(number);
    return number < blocks_present_ ? coded_->look_up(number).place.offset : size_bytes();
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
    throw core::Error(core::text("%s: block %llu at byte %llu: %s", name().c_str(),
                                 static_cast<unsigned long long>(number),
                                 static_cast<unsigned long long>(offset_of(number)), what.c_str()));
}

std::span<const std::byte> Model::block(uint64_t number) const {
    if (number >= header_.node_blocks()) fault(number, "is no block of nodes");
    return any_block(number);
}

std::span<const std::byte> Model::any_block(uint64_t number) const {
    if (!is_there(number)) fault(number, "is not there");
    if (checked(number).load(std::memory_order_acquire) == 0) take_block(number);
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
    if (checked(number).load(std::memory_order_acquire) != 0) return;
    coded_->read(number, own_block(number));
    check_block(number);
}

void Model::check_block(uint64_t number) const {
    const std::span bytes(blocks_ + number * header_.block_size, header_.block_size);
    uint32_t stored;
    std::memcpy(&stored, bytes.data(), sizeof(stored));
    const uint32_t found = block_checksum(bytes, number);
    if (found != stored) fault(number, core::wrong_checksum(found, stored, 8));
    if (number < header_.node_blocks()) check_nodes(number, bytes);
    if (checked(number).exchange(1, std::memory_order_acq_rel) == 0)
        blocks_used_.fetch_add(1, std::memory_order_relaxed);
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
    colour_ =
        model.header().has_colour() ? reinterpret_cast<const uint16_t*>(bytes + layout.colour) : nullptr;
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
