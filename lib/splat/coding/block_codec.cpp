#include "splat/coding/block_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>

#include "splat/coding/symbol_coder.h"
#include "splat/node.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/coding/block_codec.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/coding/block_symbols-inl.h"
#include "splat/coding/symbol_decoder-inl.h"

#ifndef QS_SPLAT_BLOCK_CODEC_ONCE
#define QS_SPLAT_BLOCK_CODEC_ONCE
namespace splat {
namespace {

struct NodeLanes {
    static constexpr uint32_t kCount = 6, kBits[] = {9, 9, 8, 8, 8, 9};
};

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
    uint32_t checksum;                // of the plain block
    std::span<const std::byte> more;  // what its header holds besides, as it is
};

size_t more_header_bytes(const BlockLayout& layout) {
    return layout.attitude - sizeof(BlockHeader);
}

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
class NodesToFill {
  public:
    NodesToFill(const BlockLayout& layout, std::byte* block) : arrays_(layout, block) {}
    static uint32_t group_size() { return 1; }
    static void get(uint32_t, uint32_t, RunCodes&) {}
    // All of the run: so the compiler knows of how many, and does many at once.
    HWY_INLINE void put(uint32_t first, uint32_t count, RunCodes& run) {
        uint16_t attitude[kRunNodes], place[kRunNodes];
        uint8_t shape[kRunNodes / 2];
        for (uint32_t i = 0; i < kRunNodes; ++i) {
            const auto normal = uint16_t((run.normal[1][i] + 15) * kNormalSteps + run.normal[0][i] + 15);
            attitude[i] = uint16_t(run.attitude[i] | normal << 5 | (run.shape[i] >> 4) << 15);
            place[i] = uint16_t(run.radius[i] | run.across[i] << 4 | run.along[i] << 11);
        }
        if (count % 2 != 0) run.shape[count] = 0;
        for (uint32_t i = 0; i < kRunNodes / 2; ++i)
            shape[i] = uint8_t((run.shape[2 * i] & 15) | run.shape[2 * i + 1] << 4);
        std::memcpy(arrays_.attitude + 2 * first, attitude, 2 * count);
        std::memcpy(arrays_.place + 2 * first, place, 2 * count);
        std::memcpy(arrays_.shape + first / 2, shape, (count + 1) / 2);
    }
    HWY_INLINE void put_colours(uint32_t first, uint32_t count, const RunCodes& run) {
        std::memcpy(arrays_.colour + 2 * first, run.colour.data(), 2 * count);
    }

  private:
    Arrays<std::byte> arrays_;
};

struct NodesToForget {
    static uint32_t group_size() { return 1; }
    static void get(uint32_t, uint32_t, RunCodes&) {}
    static void put(uint32_t, uint32_t, const RunCodes&) {}
    static void put_colours(uint32_t, uint32_t, const RunCodes&) {}
};

template <bool kHasColour, bool kMeasures, class Nodes>
bool Decode(const Decoding& d, Nodes nodes) {
    using Decoder = SymbolDecoder<NodeLanes, kMeasures>;
    std::byte tail[2 * Decoder::kReadAhead] = {};
    Decoder decoder(d.tables, d.bits, tail, d.field_bits);
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
using symbols::RunCodes;

// The nodes of a plain block, and its groups in turn.
class NodesToCode {
  public:
    NodesToCode(const BlockLayout& layout, const PlainBlock& block, bool has_colour)
        : arrays_(layout, block.bytes.data()), groups_(block.groups), has_colour_(has_colour) {}
    uint32_t group_size() { return groups_[next_group_++]; }
    void get(uint32_t first, uint32_t count, RunCodes& run) const {
        for (uint32_t i = 0, slot = first; i < count; ++i, ++slot) {
            const uint32_t attitude = arrays_.get(arrays_.attitude, slot),
                           place = arrays_.get(arrays_.place, slot);
            const uint32_t pair = uint32_t(arrays_.shape[slot / 2]);
            const uint32_t normal = attitude >> 5 & 1023;
            run.shape[i] = uint8_t((slot & 1 ? pair >> 4 : pair & 15) | (attitude >> 15) << 4);
            run.attitude[i] = uint8_t(attitude & 31);
            run.radius[i] = uint8_t(place & 15);
            run.across[i] = uint8_t(place >> 4 & 127);
            run.normal[0][i] = int8_t(int32_t(normal % kNormalSteps) - 15);
            run.normal[1][i] = int8_t(int32_t(normal / kNormalSteps) - 15);
            run.along[i] = uint8_t(place >> 11);
            if (has_colour_) run.colour[i] = uint16_t(arrays_.get(arrays_.colour, slot));
        }
    }
    static void put(uint32_t, uint32_t, const RunCodes&) {}
    static void put_colours(uint32_t, uint32_t, const RunCodes&) {}

  private:
    Arrays<const std::byte> arrays_;
    std::span<const uint8_t> groups_;
    bool has_colour_;
    size_t next_group_ = 0;
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
    SymbolCounter counter(counts);
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
    SymbolEncoder<NodeLanes> encoder(tables);
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
