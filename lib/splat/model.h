// A splat model that is being read: a mapped file, or a prefix of one, or one of which more and more arrives.
//
// Blocks are checked when they are first used (checksum, counts, pointers), once, by whichever
// thread comes first; after that nodes are decoded straight from the mapped bytes.  Those of a compressed
// file are then first brought into their plain form, into memory of the model's own: it takes what is used of
// it, and keeps it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/address_space.h"
#include "core/file.h"
#include "splat/block_source.h"
#include "splat/coding/coded_file.h"
#include "splat/format.h"
#include "splat/node.h"

namespace splat {

// How many bytes from the beginning of a file its header takes, with what is needed to read blocks; told by
// the first 1024 of them, or all.
uint64_t header_extent(std::span<const std::byte> head);

// Where a sibling group lies: `slot` of its first node in `block`.
struct GroupAt {
    uint64_t block = 0;
    uint32_t slot = 0;
    bool operator==(const GroupAt&) const = default;
};

class Model {
  public:
    // `path` "-" is standard input.  A file that is cut off is a coarser model.
    // Throws core::Error: not a model, header damaged, not one whole block; of a compressed one also: no
    // address space for it.
    explicit Model(const std::string& path);
    Model(core::InputFile file);
    // One that is arriving: its header must be there, all of header_extent().  Throws core::Error as above,
    // and where the source does not have all of a compressed one.
    explicit Model(std::unique_ptr<const BlockSource> source);

    const Header& header() const { return header_; }
    std::array<std::byte, kHeaderSize> header_bytes() const;  // as they stand in the plain file
    const BlockLayout& layout() const { return layout_; }
    const std::string& name() const { return name_; }
    // From the first one on; of a model that is arriving all may be.
    uint64_t blocks_present() const { return blocks_present_; }
    uint64_t node_blocks_present() const { return std::min(blocks_present_, header_.node_blocks()); }
    bool is_arriving() const { return source_ != nullptr; }
    bool is_complete() const { return !source_ && blocks_present_ == header_.block_count; }
    size_t size_bytes() const { return source_ ? size_t(source_->file_bytes()) : file_->bytes().size(); }
    const CodedFile* coded() const { return coded_.get(); }  // null where the file is plain

    // What a block takes in the file, in the mean; in a plain one each does.
    uint64_t mean_block_bytes() const;

    // Of one that is arriving: the bytes of the file that are needed next for a block.  They are its own, or,
    // in a compressed one, those of a page of the index that is needed to find it.
    FoundPlace next_bytes(uint64_t block) const;

    // Bytes from the beginning of the file to the end of a block that is present.
    uint64_t prefix_bytes(uint64_t block) const;

    Node root() const;

    // Whether a block of nodes, or of either kind, is there.  Of a model that is arriving the answer stays
    // the same until take_stock().  From any thread.
    bool has_block(uint64_t block) const { return block < node_blocks_present() && is_there(block); }
    bool is_there(uint64_t block) const {
        if (!source_) return block < blocks_present_;
        if (block >= blocks_present_) return false;
        const uint32_t known = stock_of(block).load(std::memory_order_acquire);
        return known >> 1 == stock_ ? known & 1 : look_for(block);
    }

    // From here on what has arrived by the time it is asked for is there.  Between the walks of frames, not
    // during one.
    void take_stock() const { ++stock_; }
    uint32_t stock() const { return stock_; }  // how often it was taken, from 1

    // The bytes of a block of nodes that is present, checked.  Throws core::Error
    // "<name>: block 7 at byte 8192: ...".
    std::span<const std::byte> block(uint64_t number) const;

    // The same of a block of triangles.
    std::span<const std::byte> triangle_block(uint64_t number) const;

    // The same of a block of either kind, all of it.
    std::span<const std::byte> any_block(uint64_t number) const;

    // Asks for the memory of a group that will be read soon; nothing where it is not there.
    void prefetch(const GroupAt& group) const;

    // How many blocks were used so far (for reports).
    uint64_t blocks_used() const { return blocks_used_.load(std::memory_order_relaxed); }

    // Throws for a fault in `number` that the checksum does not show.
    [[noreturn]] void fault(uint64_t number, const std::string& what) const;

  private:
    uint64_t offset_of(uint64_t number) const;
    void check_block(uint64_t number) const;
    void check_nodes(uint64_t number, std::span<const std::byte> bytes) const;
    void take_block(uint64_t number) const;
    void take_coded(uint64_t blocks_present);
    void make_room_for_blocks();
    bool look_for(uint64_t number) const;
    bool has_arrived(uint64_t number) const;
    std::atomic_ref<uint8_t> checked(uint64_t number) const {
        return std::atomic_ref(reinterpret_cast<uint8_t*>(checked_.bytes().data())[number]);
    }
    std::atomic_ref<uint32_t> stock_of(uint64_t number) const {
        return std::atomic_ref(reinterpret_cast<uint32_t*>(looked_for_.bytes().data())[number]);
    }
    std::span<std::byte> own_block(uint64_t number) const {
        return own_.bytes().subspan(number * header_.block_size, header_.block_size);
    }

    std::optional<core::InputFile> file_;        // empty where it is arriving
    std::unique_ptr<const BlockSource> source_;  // null: all that will ever be there is
    std::string name_;
    Header header_;
    BlockLayout layout_;
    std::unique_ptr<CodedFile> coded_;
    core::AddressSpace own_;                     // plain blocks of a compressed file
    const std::byte* blocks_ = nullptr;          // plain blocks
    mutable std::array<std::mutex, 16> taking_;  // by block number: two threads do not fill one block
    uint64_t blocks_present_ = 0;
    core::AddressSpace checked_;  // by block: 1 where it was
    core::AddressSpace
        looked_for_;  // by block: 2 * the stock of the last look + 1 where it was there; 32 bits
    mutable uint32_t stock_ = 1;
    mutable std::atomic<uint64_t> blocks_used_{0};
};

// Shapes of the block's nodes, the one that was asked for among them.
struct ShapesFrom {
    uint32_t bits;   // four a node
    uint32_t first;  // place in `bits` of the node that was asked for
};

// The nodes of one block and where their children are: a running count, done as far as it is asked for (most
// blocks hold leaves only, and nodes are asked for in their order).
class BlockView {
  public:
    void open(const Model& model, uint64_t number);
    uint64_t number() const { return number_; }
    bool is_open() const { return is_open_; }
    float middle_side() const { return middle_side_; }       // likewise
    uint64_t triangles_at() const { return triangles_at_; }  // of a model with triangles: see format.h

    uint32_t node_count() const { return node_count_; }
    const uint16_t* attitude() const { return attitude_; }
    const uint16_t* place() const { return place_; }
    const uint8_t* shape() const { return shape_; }     // two nodes a byte, even slot in the low half
    const uint16_t* colour() const { return colour_; }  // null without the channel

    uint8_t shape_of(uint32_t slot) const { return uint8_t(shape_[slot / 2] >> (slot & 1 ? 4 : 0) & 15); }
    // Of `slot` and the six after it, as far as the block has them.
    ShapesFrom shapes_from(uint32_t slot) const {
        const uint32_t byte = std::min(slot / 2, (capacity_ + 1) / 2 - 4);
        uint32_t bits;
        std::memcpy(&bits, shape_ + byte, sizeof(bits));
        return {bits, slot - 2 * byte};
    }
    int children_of(uint32_t slot) const { return attitude_[slot] & 7; }
    // Of a node with children.  Costs the nodes between it and the one that was last asked for, or between it
    // and the first where that stands behind it.
    GroupAt group_of(uint32_t slot) {
        if (slot < counted_) counted_ = 0, child_at_ = {child_block_, child_slot_};
        for (; counted_ + 4 <= slot; counted_ += 4) count_four();
        const GroupAt at = after(child_at_, counted_, slot);
        return at.slot + uint32_t(children_of(slot)) > capacity_ ? GroupAt{at.block + 1, 0} : at;
    }

  private:
    void count_four() {
        uint64_t four;
        std::memcpy(&four, attitude_ + counted_, sizeof(four));
        const uint32_t sum = uint32_t((four & 0x0007000700070007u) * 0x0001000100010001u >> 48);
        if (child_at_.slot + sum <= capacity_)
            child_at_.slot += sum;
        else
            child_at_ = after(child_at_, counted_, counted_ + 4);
    }

    // The end of the groups of nodes [first, last), if that of the nodes before is `at`.
    GroupAt after(GroupAt at, uint32_t first, uint32_t last) const {
        for (uint32_t slot = first; slot < last; ++slot) {
            const uint32_t n = uint32_t(children_of(slot));
            if (at.slot + n > capacity_) ++at.block, at.slot = 0;
            at.slot += n;
        }
        return at;
    }

    bool is_open_ = false;
    uint64_t number_ = 0, child_block_ = 0, triangles_at_ = 0;
    float middle_side_ = 0;
    uint32_t node_count_ = 0, child_slot_ = 0, capacity_ = 0;
    const uint16_t *attitude_ = nullptr, *place_ = nullptr, *colour_ = nullptr;
    const uint8_t* shape_ = nullptr;
    uint32_t counted_ = 0;  // nodes; a multiple of four
    GroupAt child_at_;      // end of their groups
};

}  // namespace splat
