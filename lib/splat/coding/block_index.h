// Where the coded blocks of a compressed model are: pages of sizes, coarse to fine, among the blocks.
//
// A page of level 0 holds the sizes of 256 blocks in a row and stands before them; one of level 1 those of
// 256 such runs, page and blocks, and stands before the first; and so on up to one page, which all begins
// with.  So a prefix of a file has the pages of what it has, and a block is found from its number through one
// page a level. man/qs.5 specifies the bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace splat {

constexpr uint32_t kPageEntries = 256;
constexpr uint64_t kMostPageBytes = 4 + 8 * uint64_t{kPageEntries};

struct CodedPlace {
    uint64_t offset, size;  // bytes, from the beginning of the file
};

// Whether bytes within a file are there.
using IsThere = std::function<bool(const CodedPlace&)>;

// What look_up() came to: a block; or a page that it is found by, and that is not there.
struct FoundPlace {
    CodedPlace place;
    bool is_block;
};

class BlockIndex {
  public:
    explicit BlockIndex(uint64_t block_count);

    uint32_t levels() const { return levels_; }
    uint64_t pages(uint32_t level) const;  // how many there are
    uint32_t entries(uint32_t level, uint64_t page) const;
    uint64_t page_bytes(uint32_t level, uint64_t page) const;
    uint64_t total_bytes() const;  // of all pages

    // A page with the sizes of what it lists: of level 0, 1 to 65536 bytes.
    std::vector<std::byte> encode_page(uint32_t level, uint64_t page, std::span<const uint64_t> sizes) const;

    // Finds a block of a file whose index begins at `begin` and whose blocks end at `end`, for which it looks
    // at pages in `file`, which may be a prefix, that `is_there` says are there.  Throws core::Error
    // "<name>: index page ...": cut off, or damaged.  What it finds lies between `begin` and `end`, blocks
    // apart from each other.
    FoundPlace look_up(std::span<const std::byte> file, uint64_t begin, uint64_t end, uint64_t block,
                       const IsThere& is_there, const std::string& name) const;

    // How many blocks a prefix has in full, from the first one on.
    uint64_t count_present(std::span<const std::byte> file, uint64_t begin, uint64_t end,
                           const std::string& name) const;

  private:
    struct Page;

    Page open(std::span<const std::byte> file, CodedPlace run, uint32_t level, uint64_t page,
              const std::string& name) const;

    uint64_t block_count_;
    uint32_t levels_ = 1;
};

}  // namespace splat
