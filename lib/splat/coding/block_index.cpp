#include "splat/coding/block_index.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "core/bytes.h"
#include "core/error.h"

namespace splat {

namespace {

constexpr uint64_t kPageHeader = 4;  // its checksum

constexpr uint64_t entry_bytes(uint32_t level) {
    return level == 0 ? 2 : 8;
}

uint32_t checksum_of(std::span<const std::byte> entries, uint32_t level, uint64_t page) {
    return uint32_t(XXH3_64bits_withSeed(entries.data(), entries.size(), uint64_t(level) << 56 | page));
}

}  // namespace

// A page that was checked.
struct BlockIndex::Page {
    const std::byte* entries;
    uint32_t level, count;
    uint64_t begin;  // of what the first entry is about

    uint64_t size_of(uint32_t entry) const {
        if (level == 0) {
            uint16_t less_one;
            std::memcpy(&less_one, entries + 2 * entry, 2);
            return uint64_t(less_one) + 1;
        }
        uint64_t size;
        std::memcpy(&size, entries + 8 * entry, 8);
        return size;
    }
    // Of the first entries; none is above `limit`, or the sum is.  Sizes of blocks cannot sum up to too much.
    uint64_t sum_of(uint32_t entry_count, uint64_t limit) const {
        uint64_t sum = 0;
        if (level == 0) {
            std::array<uint16_t, kPageEntries> less_one;
            std::memcpy(less_one.data(), entries, 2 * size_t(entry_count));
            uint32_t small_sum = entry_count;
            for (uint32_t e = 0; e < entry_count; ++e) small_sum += less_one[e];
            return small_sum;
        }
        for (uint32_t e = 0; e < entry_count && sum <= limit; ++e) {
            const uint64_t size = size_of(e);
            sum = size <= limit ? sum + size : limit + 1;
        }
        return sum;
    }
    CodedPlace place_of(uint32_t entry) const {
        return {begin + sum_of(entry, std::numeric_limits<uint64_t>::max()), size_of(entry)};
    }
};

BlockIndex::BlockIndex(uint64_t block_count) : block_count_(block_count) {
    while (pages(levels_ - 1) > 1) ++levels_;
}

uint64_t BlockIndex::pages(uint32_t level) const {
    return ((block_count_ - 1) >> 8 * (level + 1)) + 1;
}

uint32_t BlockIndex::entries(uint32_t level, uint64_t page) const {
    const uint64_t listed = level == 0 ? block_count_ : pages(level - 1);
    return uint32_t(std::min<uint64_t>(kPageEntries, listed - page * kPageEntries));
}

uint64_t BlockIndex::page_bytes(uint32_t level, uint64_t page) const {
    return kPageHeader + entry_bytes(level) * entries(level, page);
}

uint64_t BlockIndex::total_bytes() const {
    uint64_t sum = 0;
    for (uint32_t level = 0; level < levels_; ++level) {
        const uint64_t listed = level == 0 ? block_count_ : pages(level - 1);
        sum += pages(level) * kPageHeader + listed * entry_bytes(level);
    }
    return sum;
}

std::vector<std::byte> BlockIndex::encode_page(uint32_t level, uint64_t page,
                                               std::span<const uint64_t> sizes) const {
    core::ByteWriter out;
    out.put(uint32_t(0));
    for (const uint64_t size : sizes) level == 0 ? out.put(uint16_t(size - 1)) : out.put(size);
    const uint32_t sum = checksum_of(std::span(out.bytes).subspan(kPageHeader), level, page);
    std::memcpy(out.bytes.data(), &sum, sizeof(sum));
    return std::move(out.bytes);
}

BlockIndex::Page BlockIndex::open(std::span<const std::byte> file, CodedPlace run, uint32_t level,
                                  uint64_t page, const std::string& name) const {
    const auto refuse = [&](const std::string& what) {
        throw core::Error(core::text("%s: index page %llu of level %u at byte %llu: %s", name.c_str(),
                                     static_cast<unsigned long long>(page), level,
                                     static_cast<unsigned long long>(run.offset), what.c_str()));
    };
    const uint64_t size = page_bytes(level, page);
    if (size > run.size) refuse("is longer than what it lists");
    if (run.offset + size > file.size()) refuse("is cut off");
    const auto bytes = file.subspan(run.offset, size);
    uint32_t sum;
    std::memcpy(&sum, bytes.data(), sizeof(sum));
    const auto listed = bytes.subspan(kPageHeader);
    const uint32_t found = checksum_of(listed, level, page);
    if (sum != found) refuse(core::wrong_checksum(found, sum, 8));
    const Page result{listed.data(), level, entries(level, page), run.offset + size};
    const uint64_t room = run.size - size, listed_size = result.sum_of(result.count, room);
    if (listed_size != room)
        refuse(listed_size < room ? "lists less than there is room for"
                                  : "lists more than there is room for");
    return result;
}

FoundPlace BlockIndex::look_up(std::span<const std::byte> file, uint64_t begin, uint64_t end, uint64_t block,
                               const IsThere& is_there, const std::string& name) const {
    CodedPlace place{begin, end - begin};
    for (uint32_t level = levels_; level-- > 0;) {
        const uint64_t page = block >> 8 * (level + 1);
        // One that is longer than its run, or the file, is damaged: open() says so.
        const CodedPlace of_page{place.offset, page_bytes(level, page)};
        const bool is_possible = of_page.size <= place.size && of_page.offset + of_page.size <= file.size();
        if (is_possible && !is_there(of_page)) return {of_page, false};
        place = open(file, place, level, page, name).place_of(block >> 8 * level & 255);
    }
    return {place, true};
}

uint64_t BlockIndex::count_present(std::span<const std::byte> file, uint64_t begin, uint64_t end,
                                   const std::string& name) const {
    if (file.size() >= end) return block_count_;
    CodedPlace place{begin, end - begin};
    uint64_t present = 0;
    for (uint32_t level = levels_; level-- > 0;) {
        const uint64_t number = present >> 8 * (level + 1);
        if (place.offset + page_bytes(level, number) > file.size()) break;
        const Page page = open(file, place, level, number, name);
        uint32_t whole = 0;
        place = page.place_of(0);
        while (place.offset + place.size <= file.size()) {
            ++whole;
            place = {place.offset + place.size, page.size_of(whole)};
        }
        present += uint64_t(whole) << 8 * level;
    }
    return present;
}

}  // namespace splat
