#include "splat/block_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>

#include "splat/node.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/block_codec.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/block_symbols-inl.h"

#ifndef QS_SPLAT_BLOCK_CODEC_ONCE
#define QS_SPLAT_BLOCK_CODEC_ONCE
namespace splat {
namespace {

constexpr uint32_t kLanes = 6;
constexpr uint32_t kLaneBits[kLanes] = {9, 9, 8, 8, 8, 9};

// A block's arrays, to be read or filled.
template <class Byte>
struct Arrays {
    Arrays(const BlockLayout& layout, Byte* block)
        : attitude(block + layout.attitude),
          place(block + layout.place),
          colour(block + layout.colour),
          shape(block + layout.shape) {}

    static uint32_t get(const std::byte* array, uint32_t slot) {
        uint16_t value;
        std::memcpy(&value, array + 2 * slot, 2);
        return value;
    }
    static void put(std::byte* array, uint32_t slot, uint32_t value) {
        const uint16_t v = uint16_t(value);
        std::memcpy(array + 2 * slot, &v, 2);
    }

    Byte *attitude, *place, *colour, *shape;
};

// What stands before a block's bits.
struct CodedHead {
    uint32_t node_count;
    uint64_t ahead;  // child_block, from the block's own number
    uint16_t child_slot;
    uint32_t checksum;  // of the plain block
    std::span<const std::byte> more;  // what its header holds besides, as it is
};

// 7 bits a byte, the lowest first; the high bit says that more follow.
void put_number(uint64_t value, std::vector<std::byte>& out) {
    for (; value >= 128; value >>= 7) out.push_back(std::byte(uint8_t(value | 128)));
    out.push_back(std::byte(uint8_t(value)));
}
bool take_number(std::span<const std::byte>& bytes, uint64_t& value) {
    value = 0;
    for (uint32_t shift = 0; shift < 63; shift += 7) {
        if (bytes.empty()) return false;
        const uint64_t byte = uint64_t(bytes[0]);
        bytes = bytes.subspan(1);
        value |= (byte & 127) << shift;
        if (byte < 128) return true;
    }
    return false;
}

size_t more_header_bytes(const BlockLayout& layout) { return layout.attitude - sizeof(BlockHeader); }

// Takes the head off `coded`, and leaves the bits.
bool take_head(const BlockLayout& layout, std::span<const std::byte>& coded, CodedHead& head) {
    uint64_t unused;
    if (!take_number(coded, unused) || unused >= layout.capacity || !take_number(coded, head.ahead))
        return false;
    head.node_count = layout.capacity - uint32_t(unused);
    constexpr size_t kRest = sizeof(head.child_slot) + sizeof(head.checksum);
    const size_t more = more_header_bytes(layout);
    if (coded.size() < kRest + more) return false;
    std::memcpy(&head.child_slot, coded.data(), sizeof(head.child_slot));
    std::memcpy(&head.checksum, coded.data() + sizeof(head.child_slot), sizeof(head.checksum));
    head.more = coded.subspan(kRest, more);
    coded = coded.subspan(kRest + more);
    return true;
}

// Decodes `count` nodes from `bits` into the arrays of `block`, or, without a block, adds to `field_bits`.
struct Decoding {
    const BlockLayout& layout;
    const DecodingTables& tables;
    std::span<const std::byte> bits;
    uint32_t count;
    std::byte* block;
    double* field_bits;
};

}  // namespace
}  // namespace splat
#endif

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The states of a block that is being decoded, and its bits.
template <bool kMeasures>
class Decoder {
  public:
    static constexpr ptrdiff_t kNodeBytes =
        24;  // more than is taken between two begin_node(), and read at once

    // `tail` of 2 kNodeBytes, of zeros.
    HWY_INLINE Decoder(const Decoding& d, std::byte* tail)
        : tables_(d.tables.states.data()),
          bits_(d.bits.data()),
          size_(d.bits.size()),
          tail_(tail),
          field_bits_(d.field_bits) {
        static_cast<void>(begin_node());
        for (uint32_t lane = 0; lane < kLanes; ++lane) states_[lane] = take(kLaneBits[lane]);
    }

    // The last bytes are read from a copy with room behind it, so that nodes need not look for the end.
    HWY_INLINE bool begin_node() {
        const uint64_t byte = at_ >> 3;
        if (HWY_UNLIKELY(byte + kNodeBytes > size_)) {
            if (byte > size_) return false;
            if (tail_ != nullptr) {
                if (byte < size_) std::memcpy(tail_, bits_ + byte, size_ - byte);
                bits_ = tail_ - byte, tail_ = nullptr;
            }
        }
        // At least 57 bits are there then.
        std::memcpy(&ahead_, bits_ + byte, sizeof(ahead_));
        ahead_ >>= at_ & 7;
        return true;
    }

    template <int kLane, SymbolKind kKind>
    HWY_INLINE uint32_t code(uint32_t context, uint32_t) {
        constexpr SymbolField kField = kSymbolFields[kKind];
        static_assert(kField.bits == kLaneBits[kLane]);
        const uint32_t entry = tables_[kField.first_state + (context << kField.bits) + states_[kLane]];
        const uint32_t next = entry >> 5;
        const uint32_t bits = uint32_t(std::countr_zero(next));
        if (kMeasures) field_bits_[kKind] += bits;
        states_[kLane] = ((next & (next - 1)) >> 1) + take(bits);
        return entry & (kSymbolCount - 1);
    }

    template <uint32_t kBits>
    HWY_INLINE uint32_t plain(uint32_t) {
        return take(kBits);
    }

    // Whether all bits were taken but for what fills the last byte, and the states are those that encoders
    // begin with.
    HWY_INLINE bool is_at_end() const {
        uint32_t any = 0;
        for (uint32_t lane = 0; lane < kLanes; ++lane) any |= states_[lane];
        return any == 0 && (at_ + 7) >> 3 == size_;
    }

  private:
    HWY_INLINE uint32_t take(uint32_t bits) {
        const uint32_t value = uint32_t(ahead_) & ((1u << bits) - 1);
        ahead_ >>= bits;
        at_ += bits;
        return value;
    }

    uint32_t states_[kLanes];
    uint64_t ahead_ = 0, at_ = 0;  // bits that were read but not taken, and the first one's place
    const uint16_t* tables_;
    const std::byte* bits_;
    uint64_t size_;    // in bytes
    std::byte* tail_;  // null once it is read
    double* field_bits_;
};

class NodesToFill {
  public:
    NodesToFill(const BlockLayout& layout, std::byte* block) : arrays_(layout, block) {}
    static uint32_t group_size() { return 1; }
    static void get(uint32_t, NodeCodes&) {}
    HWY_INLINE void put(uint32_t slot, const NodeCodes& n) {
        const uint32_t normal = uint32_t((n.normal[1] + 15) * kNormalSteps + n.normal[0] + 15);
        arrays_.put(arrays_.attitude, slot, n.attitude | normal << 5 | (n.shape >> 4) << 15);
        arrays_.put(arrays_.place, slot, n.radius | n.across << 4 | uint32_t(n.along) << 11);
        std::byte& pair = arrays_.shape[slot / 2];
        pair = slot & 1 ? pair | std::byte(uint8_t((n.shape & 15) << 4)) : std::byte(uint8_t(n.shape & 15));
    }
    HWY_INLINE void put_colour(uint32_t slot, uint32_t colour) { arrays_.put(arrays_.colour, slot, colour); }

  private:
    Arrays<std::byte> arrays_;
};

struct NodesToForget {
    static uint32_t group_size() { return 1; }
    static void get(uint32_t, NodeCodes&) {}
    static void put(uint32_t, const NodeCodes&) {}
    static void put_colour(uint32_t, uint32_t) {}
};

template <bool kHasColour, bool kMeasures, class Nodes>
bool Decode(const Decoding& d, Nodes nodes) {
    std::byte tail[2 * Decoder<kMeasures>::kNodeBytes] = {};
    Decoder<kMeasures> decoder(d, tail);
    return CodeNodes<kHasColour>(decoder, nodes, d.count) && decoder.is_at_end();
}

bool DecodeNodes(const Decoding& d, bool has_colour) {
    if (d.block == nullptr)
        return has_colour ? Decode<true, true>(d, NodesToForget()) : Decode<false, true>(d, NodesToForget());
    const NodesToFill nodes(d.layout, d.block);
    return has_colour ? Decode<true, false>(d, nodes) : Decode<false, false>(d, nodes);
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(DecodeNodes);

namespace {

namespace symbols = HWY_NAMESPACE;
using symbols::NodeCodes;

// The nodes of a plain block, and its groups in turn.
class NodesToCode {
  public:
    NodesToCode(const BlockLayout& layout, const PlainBlock& block, bool has_colour)
        : arrays_(layout, block.bytes.data()), groups_(block.groups), has_colour_(has_colour) {}
    uint32_t group_size() { return groups_[next_group_++]; }
    void get(uint32_t slot, NodeCodes& n) const {
        const uint32_t attitude = arrays_.get(arrays_.attitude, slot),
                       place = arrays_.get(arrays_.place, slot);
        const uint32_t pair = uint32_t(arrays_.shape[slot / 2]);
        const uint32_t normal = attitude >> 5 & 1023;
        n.shape = (slot & 1 ? pair >> 4 : pair & 15) | (attitude >> 15) << 4;
        n.attitude = attitude & 31;
        n.radius = place & 15;
        n.across = place >> 4 & 127;
        n.normal[0] = int32_t(normal % kNormalSteps) - 15, n.normal[1] = int32_t(normal / kNormalSteps) - 15;
        n.along = int32_t(place >> 11);
        if (has_colour_) n.colour = arrays_.get(arrays_.colour, slot);
    }
    static void put(uint32_t, const NodeCodes&) {}
    static void put_colour(uint32_t, uint32_t) {}

  private:
    Arrays<const std::byte> arrays_;
    std::span<const uint8_t> groups_;
    bool has_colour_;
    size_t next_group_ = 0;
};

class Counter {
  public:
    explicit Counter(SymbolCounts& counts) : counts_(counts) {}
    static bool begin_node() { return true; }
    template <uint32_t kBits>
    static uint32_t plain(uint32_t value) {
        return value;
    }
    template <int kLane, SymbolKind kKind>
    uint32_t code(uint32_t context, uint32_t symbol) {
        ++counts_[size_t(kSymbolFields[kKind].first_context + context) * kSymbolCount + symbol];
        return symbol;
    }

  private:
    SymbolCounts& counts_;
};

// Notes the symbols, and codes them from the last to the first: a decoder takes them the other way.
class Encoder {
  public:
    explicit Encoder(const EncodingTables& tables) : tables_(tables) {}
    static bool begin_node() { return true; }
    template <uint32_t kBits>
    uint32_t plain(uint32_t value) {
        steps_.push_back({kPlain, 0, uint8_t(kBits), uint8_t(value)});
        return value;
    }
    template <int kLane, SymbolKind kKind>
    uint32_t code(uint32_t context, uint32_t symbol) {
        steps_.push_back({kKind, kLane, uint8_t(context), uint8_t(symbol)});
        return symbol;
    }

    void finish(std::vector<std::byte>& out) {
        std::vector<Bits> bits;  // the last first
        uint32_t states[kLanes] = {};
        for (size_t i = steps_.size(); i-- > 0;) bits.push_back(step(steps_[i], states[steps_[i].lane]));
        for (uint32_t lane = kLanes; lane-- > 0;)
            bits.push_back({uint16_t(states[lane]), uint16_t(kLaneBits[lane])});
        uint64_t pending = 0;
        uint32_t count = 0;
        for (size_t i = bits.size(); i-- > 0;) {
            pending |= uint64_t(bits[i].value) << count;
            for (count += bits[i].count; count >= 8; count -= 8, pending >>= 8)
                out.push_back(std::byte(uint8_t(pending)));
        }
        if (count > 0) out.push_back(std::byte(uint8_t(pending)));
    }

  private:
    static constexpr uint8_t kPlain = kSymbolKinds;  // no symbol, but so many bits as they are
    struct Step {
        uint8_t kind, lane, context, symbol;
    };
    struct Bits {
        uint16_t value, count;
    };

    // Goes from the state after a symbol to that before it; returns the bits that lead back.
    Bits step(const Step& at, uint32_t& state) const {
        if (at.kind == kPlain) return {at.symbol, at.context};
        const SymbolField& field = kSymbolFields[at.kind];
        const uint32_t context = field.first_context + at.context, share = tables_.shares[context][at.symbol];
        const uint32_t from = state + (1u << field.bits);
        uint32_t count = 0;
        while (from >> count >= 2 * share) ++count;
        const uint32_t first =
            field.first_state + (uint32_t(at.context) << field.bits) + tables_.first[context][at.symbol];
        state = tables_.states[first + (from >> count) - share];
        return {uint16_t(from & ((1u << count) - 1)), uint16_t(count)};
    }

    const EncodingTables& tables_;
    std::vector<Step> steps_;
};

template <class Coder>
void code_nodes(const BlockLayout& layout, bool has_colour, const PlainBlock& block, uint32_t count,
                Coder& coder) {
    NodesToCode nodes(layout, block, has_colour);
    has_colour ? symbols::CodeNodes<true>(coder, nodes, count)
               : symbols::CodeNodes<false>(coder, nodes, count);
}

BlockHeader head_of(std::span<const std::byte> block) {
    BlockHeader head;
    std::memcpy(&head, block.data(), sizeof(head));
    return head;
}

}  // namespace

bool BlockCodec::can_code(const PlainBlock& block) const {
    const BlockHeader head = head_of(block.bytes);
    if (head.node_count == 0 || head.node_count > layout_.capacity || head.child_block < block.number ||
        head.child_block - block.number >= uint64_t(1) << 46)
        return false;
    const bool are_sizes = std::all_of(block.groups.begin(), block.groups.end(),
                                       [](uint8_t size) { return size >= 1 && size <= kMaxFanOut; });
    if (!are_sizes || std::accumulate(block.groups.begin(), block.groups.end(), 0u) != head.node_count)
        return false;
    const Arrays arrays(layout_, block.bytes.data());
    for (uint32_t slot = 0; slot < head.node_count; ++slot)
        if ((arrays.get(arrays.attitude, slot) >> 5 & 1023) >= uint32_t(kNormalSteps * kNormalSteps) ||
            (arrays.get(arrays.place, slot) >> 4 & 127) >= uint32_t(kAcrossSteps * kAcrossSteps))
            return false;
    return true;
}

void BlockCodec::count(const PlainBlock& block, SymbolCounts& counts) const {
    Counter counter(counts);
    code_nodes(layout_, has_colour_, block, head_of(block.bytes).node_count, counter);
}

std::vector<std::byte> BlockCodec::encode(const PlainBlock& block, const EncodingTables& tables) const {
    const BlockHeader head = head_of(block.bytes);
    std::vector<std::byte> out;
    put_number(layout_.capacity - head.node_count, out);
    put_number(head.child_block - block.number, out);
    for (int shift = 0; shift < 16; shift += 8) out.push_back(std::byte(uint8_t(head.child_slot >> shift)));
    for (int shift = 0; shift < 32; shift += 8) out.push_back(std::byte(uint8_t(head.checksum >> shift)));
    const auto more = block.bytes.subspan(sizeof(BlockHeader), more_header_bytes(layout_));
    out.insert(out.end(), more.begin(), more.end());
    Encoder encoder(tables);
    code_nodes(layout_, has_colour_, block, head.node_count, encoder);
    encoder.finish(out);
    return out;
}

bool BlockCodec::decode(uint64_t number, std::span<const std::byte> coded, const DecodingTables& tables,
                        std::span<std::byte> block) const {
    CodedHead head;
    if (!take_head(layout_, coded, head) ||
        !HWY_DYNAMIC_DISPATCH(DecodeNodes)({layout_, tables, coded, head.node_count, block.data(), nullptr},
                                           has_colour_))
        return false;
    const BlockHeader plain{head.checksum, uint16_t(head.node_count), head.child_slot, number + head.ahead};
    std::memcpy(block.data(), &plain, sizeof(plain));
    std::copy(head.more.begin(), head.more.end(), block.begin() + sizeof(plain));
    return true;
}

bool BlockCodec::measure(std::span<const std::byte> coded, const DecodingTables& tables,
                         std::span<double> bits) const {
    CodedHead head;
    return take_head(layout_, coded, head) &&
           HWY_DYNAMIC_DISPATCH(DecodeNodes)({layout_, tables, coded, head.node_count, nullptr, bits.data()},
                                             has_colour_);
}

}  // namespace splat
#endif
