#include "mutations.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

// The distribution classes of <random> differ between libraries; the engine does not.
namespace fuzz {

namespace {

constexpr uint8_t kEvil[] = {0x00, 0x7f, 0x80, 0xff, '-', '9', ' ', '\n'};
constexpr uint32_t kEvilWords[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0x10000};

size_t below(size_t bound, std::mt19937_64& random) {
    return static_cast<size_t>(random() % bound);
}

// A run of at most 64 bytes somewhere in `bytes`, which are not empty.
struct Run {
    std::ptrdiff_t begin, end;
};
Run any_run(const Bytes& bytes, std::mt19937_64& random) {
    const size_t begin = below(bytes.size(), random);
    const size_t size = 1 + below(std::min<size_t>(64, bytes.size() - begin), random);
    return {static_cast<std::ptrdiff_t>(begin), static_cast<std::ptrdiff_t>(begin + size)};
}

void set_word(Bytes& bytes, std::mt19937_64& random) {
    if (bytes.size() < 4) return;
    const size_t at = below(bytes.size() - 3, random);
    const uint32_t word = kEvilWords[below(std::size(kEvilWords), random)];
    for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<uint8_t>(word >> 8 * i);
}

void insert_run(Bytes& bytes, const Bytes& from, std::mt19937_64& random) {
    if (from.empty()) return;
    const Run run = any_run(from, random);
    const Bytes copy(from.begin() + run.begin, from.begin() + run.end);  // `from` may be `bytes`
    const auto at = static_cast<std::ptrdiff_t>(below(bytes.size() + 1, random));
    bytes.insert(bytes.begin() + at, copy.begin(), copy.end());
}

void remove_run(Bytes& bytes, std::mt19937_64& random) {
    if (bytes.empty()) return;
    const Run run = any_run(bytes, random);
    bytes.erase(bytes.begin() + run.begin, bytes.begin() + run.end);
}

}  // namespace

Bytes mutated(Bytes bytes, std::mt19937_64& random) {
    if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 1));
    for (uint64_t n = random() % 4; n > 0 && !bytes.empty(); --n) {
        // Half of the changes go to the front: headers are read there.
        const size_t reach = random() % 2 == 0 ? std::min<size_t>(bytes.size(), 256) : bytes.size();
        uint8_t& byte = bytes[random() % reach];
        if (random() % 2 == 0)
            byte = static_cast<uint8_t>(byte ^ (1u << random() % 8));
        else
            byte = kEvil[random() % std::size(kEvil)];
    }
    return bytes;
}

Bytes mutated_further(Bytes bytes, const Bytes& other, size_t limit, std::mt19937_64& random) {
    limit = std::max(limit, bytes.size());
    for (uint64_t n = 1 + random() % 4; n > 0; --n) switch (random() % 6) {
            case 0:
                insert_run(bytes, bytes, random);
                break;
            case 1:
                insert_run(bytes, other, random);
                break;
            case 2:
                remove_run(bytes, random);
                break;
            case 3:
                set_word(bytes, random);
                break;
            default:
                bytes = mutated(std::move(bytes), random);
        }
    if (bytes.size() > limit) bytes.resize(limit);
    return bytes;
}

}  // namespace fuzz
