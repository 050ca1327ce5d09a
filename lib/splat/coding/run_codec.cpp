#include "splat/coding/run_codec.h"

#include <algorithm>
#include <cstring>

#include "splat/coding/symbol_coder.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/coding/run_codec.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/coding/run_symbols-inl.h"
#include "splat/coding/symbol_decoder-inl.h"

#ifndef QS_SPLAT_RUN_CODEC_ONCE
#define QS_SPLAT_RUN_CODEC_ONCE
namespace splat {
namespace {

struct RunLanes {
    static constexpr uint32_t kCount = 4, kBits[] = {8, 8, 8, 6};
};

// Decodes `total` bits of runs from `bits` into `runs`, or, without these, adds to `field_bits`.
struct RunDecoding {
    const DecodingTables& tables;
    std::span<const std::byte> bits;
    uint64_t total;
    uint32_t lattice_bits;
    std::span<std::byte> runs;
    double* field_bits;
};

}  // namespace
}  // namespace splat
#endif

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {

// Bits that are written from the first to the last, whole words at a time; the last ones into a copy with
// room behind it.
class RowToFill {
  public:
    static constexpr bool kIsKnown = false;
    // More than is written between two begin().
    static constexpr size_t kRoom = 32;

    // `tail` of 3 kRoom bytes: not in here, or each word that is written could be one of these members.
    HWY_INLINE RowToFill(std::span<std::byte> bytes, std::byte* tail)
        : out_(bytes.data()), bytes_(bytes), tail_(tail) {}
    HWY_INLINE bool begin() {
        if (HWY_UNLIKELY(byte_ + kRoom > bytes_.size()) && tail_at_ == kNoTail)
            tail_at_ = byte_, out_ = tail_ - byte_;
        return true;
    }
    static uint64_t peek() { return 0; }
    static uint64_t peek_behind(uint32_t) { return 0; }
    HWY_INLINE void put(uint64_t value, uint32_t width) {
        held_ |= value << count_;
        std::memcpy(out_ + byte_, &held_, sizeof(held_));
        count_ += width;
        byte_ += count_ >> 3;
        held_ >>= count_ & 56;
        count_ &= 7;
    }
    HWY_INLINE uint64_t at() const { return 8 * byte_ + count_; }
    void finish() {
        if (tail_at_ < bytes_.size()) std::memcpy(bytes_.data() + tail_at_, tail_, bytes_.size() - tail_at_);
    }

  private:
    static constexpr size_t kNoTail = ~size_t(0);
    std::byte* out_;
    size_t byte_ = 0, tail_at_ = kNoTail;
    uint64_t held_ = 0;   // of the byte that is next
    uint32_t count_ = 0;  // bits of it, below 8
    const std::span<std::byte> bytes_;
    std::byte* const tail_;
};

class RowToForget {
  public:
    static constexpr bool kIsKnown = false;
    static bool begin() { return true; }
    static uint64_t peek() { return 0; }
    static uint64_t peek_behind(uint32_t) { return 0; }
    void put(uint64_t, uint32_t width) { at_ += width; }
    uint64_t at() const { return at_; }

  private:
    uint64_t at_ = 0;
};

template <bool kMeasures, class Row>
HWY_INLINE bool DecodeRow(const RunDecoding& d, Row& row) {
    using Decoder = SymbolDecoder<RunLanes, kMeasures>;
    std::byte tail[2 * Decoder::kReadAhead] = {};
    Decoder decoder(d.tables, d.bits, tail, d.field_bits);
    return CodeRuns(decoder, row, {}, 0, d.total, d.lattice_bits) && decoder.is_at_end();
}

bool DecodeRuns(const RunDecoding& d) {
    if (d.field_bits != nullptr) {
        RowToForget row;
        return DecodeRow<true>(d, row);
    }
    std::byte tail[3 * RowToFill::kRoom] = {};
    RowToFill row(d.runs, tail);
    if (!DecodeRow<false>(d, row)) return false;
    row.finish();
    return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(DecodeRuns);

namespace {

namespace symbols = HWY_NAMESPACE;

// Bits of runs that are there.
class KnownRow {
  public:
    static constexpr bool kIsKnown = true;
    // `behind`: what follows them, or nothing.
    explicit KnownRow(std::span<const std::byte> runs, std::span<const std::byte> behind = {})
        : bytes_(runs.begin(), runs.end()) {
        behind = behind.first(std::min<size_t>(behind.size(), kRoom));
        bytes_.insert(bytes_.end(), behind.begin(), behind.end());
        bytes_.resize(runs.size() + 2 * kRoom);
    }
    static bool begin() { return true; }
    uint64_t peek() const { return peek_behind(0); }
    uint64_t peek_behind(uint32_t bits) const {
        const uint64_t at = at_ + bits;
        uint64_t word;
        std::memcpy(&word, bytes_.data() + at / 8, sizeof(word));
        return word >> at % 8;
    }
    void put(uint64_t, uint32_t width) { at_ += width; }
    uint64_t at() const { return at_; }

  private:
    static constexpr size_t kRoom = 32;  // more than a step has
    std::vector<std::byte> bytes_;
    uint64_t at_ = 0;
};

std::span<const std::byte> runs_of(std::span<const std::byte> block) {
    return block.subspan(kTriangleBlockHeader);
}

// Without the zeros at the end.
std::span<const std::byte> used_of(std::span<const std::byte> runs) {
    while (!runs.empty() && runs.back() == std::byte{0}) runs = runs.first(runs.size() - 1);
    return runs;
}

// The steps of a block, the last of which may end behind it.
struct Steps {
    RunPlace next;      // the block's that follows
    uint64_t last = 0;  // where the last one begins, or the block's end where it ends there
    bool are_runs = false;
};
Steps steps_of(KnownRow row, RunPlace place, uint64_t total, uint32_t lattice_bits) {
    SymbolReader reader;
    symbols::RunSteps steps(reader, row, lattice_bits);
    Steps found;
    if (place.part == RunPlace::lost || place.cut > total || !steps.as_they_are<kPosition>(place.cut)) {
        found.next.part = RunPlace::lost;
        return found;
    }
    found.last = row.at(), found.next = place, found.are_runs = true;
    while (row.at() < total && found.are_runs) {
        found.last = row.at();
        found.are_runs = steps.take_steps(found.next, found.last + 1);
    }
    if (!found.are_runs) found.next.part = RunPlace::lost;
    found.next.cut = uint32_t(row.at() - total);
    if (row.at() == total) found.last = total;
    return found;
}

template <class Coder>
void code_runs(const PlainRuns& runs, uint32_t lattice_bits, Coder& coder) {
    const auto used = used_of(runs_of(runs.bytes));
    const uint64_t total = 8 * used.size();
    KnownRow row(used);
    const Steps steps = steps_of(row, runs.begin, total, lattice_bits);
    symbols::CodeRuns(coder, row, runs.begin, uint32_t(total - steps.last), total, lattice_bits);
}

// What stands before a block's bits.
struct CodedRunsHead {
    uint64_t unused;    // bytes of 0 at the block's end
    uint32_t checksum;  // of the plain block
};
bool take_head(std::span<const std::byte>& coded, size_t block_size, CodedRunsHead& head) {
    if (!take_number(coded, head.unused) || head.unused > block_size - kTriangleBlockHeader ||
        coded.size() < sizeof(head.checksum))
        return false;
    std::memcpy(&head.checksum, coded.data(), sizeof(head.checksum));
    coded = coded.subspan(sizeof(head.checksum));
    return true;
}

}  // namespace

RunPlace RunCodec::end_of(const PlainRuns& runs, std::span<const std::byte> next) const {
    const auto bytes = runs_of(runs.bytes);
    const KnownRow row(bytes, next.empty() ? next : runs_of(next));
    return steps_of(row, runs.begin, 8 * bytes.size(), lattice_bits_).next;
}

bool RunCodec::can_code(const PlainRuns& runs) const {
    const auto used = used_of(runs_of(runs.bytes));
    return steps_of(KnownRow(used), runs.begin, 8 * used.size(), lattice_bits_).are_runs;
}

void RunCodec::count(const PlainRuns& runs, SymbolCounts& counts) const {
    SymbolCounter counter(counts);
    code_runs(runs, lattice_bits_, counter);
}

std::vector<std::byte> RunCodec::encode(const PlainRuns& runs, const EncodingTables& tables) const {
    const auto bytes = runs_of(runs.bytes);
    std::vector<std::byte> out;
    put_number(bytes.size() - used_of(bytes).size(), out);
    out.insert(out.end(), runs.bytes.begin(), runs.bytes.begin() + kTriangleBlockHeader);
    SymbolEncoder<RunLanes> encoder(tables);
    code_runs(runs, lattice_bits_, encoder);
    encoder.finish(out);
    return out;
}

bool RunCodec::decode(std::span<const std::byte> coded, const DecodingTables& tables,
                      std::span<std::byte> block) const {
    CodedRunsHead head;
    if (!take_head(coded, block.size(), head)) return false;
    const auto runs = block.subspan(kTriangleBlockHeader);
    if (!HWY_DYNAMIC_DISPATCH(DecodeRuns)(
            {tables, coded, 8 * (runs.size() - head.unused), lattice_bits_, runs, nullptr}))
        return false;
    std::memcpy(block.data(), &head.checksum, sizeof(head.checksum));
    return true;
}

bool RunCodec::measure(std::span<const std::byte> coded, const DecodingTables& tables, uint32_t block_size,
                       std::span<double> bits) const {
    CodedRunsHead head;
    return take_head(coded, block_size, head) &&
           HWY_DYNAMIC_DISPATCH(DecodeRuns)({tables,
                                             coded,
                                             8 * (block_size - kTriangleBlockHeader - head.unused),
                                             lattice_bits_,
                                             {},
                                             bits.data()});
}

}  // namespace splat
#endif
