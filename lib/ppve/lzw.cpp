#include "ppve/lzw.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/error.h"

namespace ppve {

namespace {

constexpr uint32_t kFirstCode = 256, kMostBits = 16, kFull = 1u << kMostBits;

// Bits of a code that is written while `next` is the next one to be given out.
uint32_t bits_for(uint32_t next) {
    return std::clamp(uint32_t(std::bit_width(next - 1)), 9u, kMostBits);
}

class BitWriter {
  public:
    explicit BitWriter(std::vector<std::byte>& out) : out_(out) {}
    void put(uint32_t code, uint32_t bits) {
        held_ |= uint64_t(code) << count_;
        for (count_ += bits; count_ >= 8; count_ -= 8, held_ >>= 8) out_.push_back(std::byte(held_ & 0xff));
    }
    void finish() {
        if (count_ > 0) out_.push_back(std::byte(held_ & 0xff));
    }

  private:
    std::vector<std::byte>& out_;
    uint64_t held_ = 0;
    uint32_t count_ = 0;
};

class BitReader {
  public:
    explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    uint32_t take(uint32_t bits) {
        while (count_ < bits) {
            if (at_ == bytes_.size()) throw core::Error("depth image: the LZW codes end too early");
            held_ |= uint64_t(bytes_[at_++]) << count_;
            count_ += 8;
        }
        const uint32_t code = uint32_t(held_ & ((uint64_t(1) << bits) - 1));
        held_ >>= bits, count_ -= bits;
        return code;
    }
    bool is_at_end() const { return at_ == bytes_.size(); }

  private:
    std::span<const std::byte> bytes_;
    size_t at_ = 0;
    uint64_t held_ = 0;
    uint32_t count_ = 0;
};

// What follows a string by a byte: open addressing, four places a code.
class Dictionary {
  public:
    Dictionary() : keys_(kSize) { clear(); }
    void clear() {
        keys_.assign(kSize, kEmpty);
        codes_.resize(kSize);
        next_ = kFirstCode;
    }
    uint32_t next() const { return next_; }
    bool is_full() const { return next_ == kFull; }

    // The code of `prefix` and `byte`, or kNone after it was given the next code.
    static constexpr uint32_t kNone = ~0u;
    uint32_t find_or_add(uint32_t prefix, uint32_t byte) {
        const uint32_t key = prefix << 8 | byte;
        uint32_t at = key * 0x9e3779b1u >> (32 - kLogSize);
        while (keys_[at] != key) {
            if (keys_[at] == kEmpty) {
                keys_[at] = key, codes_[at] = uint16_t(next_++);
                return kNone;
            }
            at = (at + 1) & (kSize - 1);
        }
        return codes_[at];
    }

  private:
    static constexpr uint32_t kLogSize = 18, kSize = 1u << kLogSize, kEmpty = ~0u;
    std::vector<uint32_t> keys_;
    std::vector<uint16_t> codes_;
    uint32_t next_ = kFirstCode;
};

}  // namespace

std::vector<std::byte> lzw_encode(std::span<const std::byte> bytes) {
    std::vector<std::byte> out;
    if (bytes.empty()) return out;
    BitWriter writer(out);
    Dictionary dictionary;
    auto prefix = uint32_t(bytes[0]);
    for (size_t i = 1; i < bytes.size(); ++i) {
        const auto byte = uint32_t(bytes[i]);
        const uint32_t found = dictionary.find_or_add(prefix, byte);
        if (found != Dictionary::kNone) {
            prefix = found;
            continue;
        }
        writer.put(prefix, bits_for(dictionary.next() - 1));
        prefix = byte;
        if (dictionary.is_full()) dictionary.clear();
    }
    writer.put(prefix, bits_for(dictionary.next()));
    writer.finish();
    return out;
}

void lzw_decode(std::span<const std::byte> codes, std::span<std::byte> out) {
    if (out.empty()) {
        if (!codes.empty()) throw core::Error("depth image: LZW codes for no pixel");
        return;
    }
    // Of each code: where in `out` its string stood first, and how long it is.
    struct String {
        size_t at;
        uint32_t size;
    };
    std::vector<String> strings(kFull);
    BitReader reader(codes);
    uint32_t next = kFirstCode;
    size_t done = 0;
    bool is_first = true;
    String last{0, 0};
    while (done < out.size()) {
        // The encoder has given out one code more than is known here, but after the first code of a
        // dictionary.
        const uint32_t code = reader.take(bits_for(is_first ? next : next + 1));
        String now{done, 1};
        if (code < kFirstCode) {
            out[done++] = std::byte(code);
        } else {
            // The string of the code that is being made now is the last one and the byte after it.
            const bool is_making = !is_first && code == next;
            if (!is_making && code >= next)
                throw core::Error(core::text("depth image: LZW code %u of %u", code, next));
            const String from = is_making ? String{last.at, last.size + 1} : strings[code];
            if (from.size > out.size() - done)
                throw core::Error("depth image: LZW codes for more pixels than there are");
            now = {done, from.size};
            for (uint32_t k = 0; k < from.size; ++k) out[done + k] = out[from.at + k];
            done += from.size;
        }
        if (!is_first) strings[next++] = {last.at, last.size + 1};
        last = now, is_first = false;
        if (next + 1 == kFull) next = kFirstCode, is_first = true;
    }
    if (!reader.is_at_end()) throw core::Error("depth image: bytes after the LZW codes");
}

}  // namespace ppve
