// Which pixels have a surface: a bit each, row by row, and runs of them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace ppve {

// Rows begin at a new word.
class PixelMask {
  public:
    PixelMask(int width, int rows)
        : width_(width), words_((size_t(width) + 63) / 64), bits_(words_ * size_t(rows)) {}

    uint64_t* row(int j) { return bits_.data() + size_t(j) * words_; }
    const uint64_t* row(int j) const { return bits_.data() + size_t(j) * words_; }
    std::vector<uint64_t>& bits() { return bits_; }

    void set_row(int j, const uint32_t* depth) {
        for (size_t w = 0; w < words_; ++w) {
            const int count = std::min(64, width_ - 64 * int(w));
            uint64_t word = 0;
            for (int i = 0; i < count; ++i) word |= uint64_t(depth[64 * w + size_t(i)] != 0) << i;
            row(j)[w] = word;
        }
    }

    // False where a bit beyond a row's end is set.
    bool is_clean(int rows) const {
        const int used = width_ % 64;
        for (int j = 0; used != 0 && j < rows; ++j)
            if (row(j)[words_ - 1] >> used != 0) return false;
        return true;
    }

    size_t count() const {
        size_t n = 0;
        for (const uint64_t word : bits_) n += size_t(std::popcount(word));
        return n;
    }

    // Calls run(begin, end) for the row's runs in turn, and gap(begin, end) for what is between them.
    template <class Run, class Gap>
    void for_runs(int j, const Run& run, const Gap& gap) const {
        const uint64_t* words = row(j);
        int at = 0;
        while (at < width_) {
            const int begin = next(words, at, true);
            if (begin > at) gap(at, begin);
            if (begin == width_) return;
            at = next(words, begin, false);
            run(begin, at);
        }
    }

  private:
    // The first pixel from `at` on with (without) a surface, or the row's end.
    int next(const uint64_t* words, int at, bool set) const {
        while (at < width_) {
            const uint64_t word = (set ? words[at / 64] : ~words[at / 64]) >> (at % 64);
            if (word != 0) return std::min(at + std::countr_zero(word), width_);
            at = (at / 64 + 1) * 64;
        }
        return width_;
    }

    int width_;
    size_t words_;
    std::vector<uint64_t> bits_;
};

}  // namespace ppve
