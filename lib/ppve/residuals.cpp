#include "ppve/residuals.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace ppve {

namespace {

uint32_t zigzag(uint32_t difference) {
    return difference << 1 ^ uint32_t(int32_t(difference) >> 31);
}

uint32_t unzigzag(uint32_t code) {
    return code >> 1 ^ (0 - (code & 1));
}

// Four signed bytes, and the same widened; one register, on any processor.
using Bytes = int8_t __attribute__((vector_size(4)));
using Wide = int16_t __attribute__((vector_size(8)));

Wide widened(uint32_t packed) {
    return __builtin_convertvector(std::bit_cast<Bytes>(packed), Wide);
}

uint32_t narrowed(Wide wide) {
    return std::bit_cast<uint32_t>(__builtin_convertvector(wide, Bytes));
}

// Modulo 2^8 in each byte.
uint32_t plus(uint32_t a, uint32_t b) {
    return ((a & 0x7f7f7f7f) + (b & 0x7f7f7f7f)) ^ ((a ^ b) & 0x80808080);
}

uint32_t minus(uint32_t a, uint32_t b) {
    return ((a | 0x80808080) - (b & 0x7f7f7f7f)) ^ ((a ^ ~b) & 0x80808080);
}

// 0x00BBGGRR as (R - G, G, B - G).
uint32_t as_differences(uint32_t colour) {
    const uint32_t green = colour >> 8 & 0xff;
    return minus(colour, green | green << 16) & 0xffffff;
}

uint32_t as_colour(uint32_t differences) {
    const uint32_t green = differences >> 8 & 0xff;
    return plus(differences, green | green << 16) & 0xffffff;
}

Wide least(Wide a, Wide b) {
    return a < b ? a : b;
}

Wide most(Wide a, Wide b) {
    return a > b ? a : b;
}

uint32_t foretold(uint32_t west, uint32_t north, uint32_t north_west) {
    const Wide w = widened(west), n = widened(north), nw = widened(north_west);
    return narrowed(most(least(w, n), least(most(w, n), w + n - nw)));
}

// Each byte's sign into its lowest bit, as zigzag() does it.
uint32_t zigzag_bytes(uint32_t differences) {
    const uint32_t signs = (differences >> 7 & 0x01010101) * 0xff;
    return ((differences << 1 & 0xfefefefe) ^ signs) & 0xffffff;
}

uint32_t unzigzag_bytes(uint32_t codes) {
    const uint32_t signs = (codes & 0x01010101) * 0xff;
    return (codes >> 1 & 0x7f7f7f7f) ^ signs;
}

}  // namespace

void depth_residuals(const Stripe& stripe, const uint32_t* depth, std::vector<uint32_t>& out) {
    const size_t width = size_t(stripe.width);
    // Heights above the row before, with gaps filled; the row before likewise.
    std::vector<uint32_t> north(width, 0), rise(width + 1, 0);
    out.resize(stripe.mask->count());
    uint32_t* to = out.data();
    for (int j = 0; j < stripe.rows; ++j, depth += width) {
        uint32_t last = 0;
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                for (int i = begin; i < end; ++i) rise[size_t(i)] = depth[i] - north[size_t(i)];
                *to++ = zigzag(rise[size_t(begin)] - last);
                for (int i = begin + 1; i < end; ++i) *to++ = zigzag(rise[size_t(i)] - rise[size_t(i) - 1]);
                last = rise[size_t(end) - 1];
                std::memcpy(&north[size_t(begin)], depth + begin, size_t(end - begin) * sizeof(uint32_t));
            },
            [&](int begin, int end) {
                for (int i = begin; i < end; ++i) north[size_t(i)] += last;
            });
    }
}

void restore_depths(const Stripe& stripe, std::span<const uint32_t> residuals, uint32_t* depth) {
    const size_t width = size_t(stripe.width);
    std::vector<uint32_t> north(width, 0);
    const uint32_t* from = residuals.data();
    for (int j = 0; j < stripe.rows; ++j, depth += width) {
        uint32_t last = 0;
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                for (int i = begin; i < end; ++i) {
                    last += unzigzag(*from++);
                    depth[i] = north[size_t(i)] += last;
                }
            },
            [&](int begin, int end) {
                for (int i = begin; i < end; ++i) north[size_t(i)] += last;
            });
    }
}

void colour_residuals(const Stripe& stripe, const uint32_t* colour, std::vector<uint32_t>& out) {
    const size_t width = size_t(stripe.width);
    // One more on the left: what is there before the first pixel.
    std::vector<uint32_t> north(width + 1, 0), now(width + 1, 0);
    out.resize(stripe.mask->count());
    uint32_t* to = out.data();
    for (int j = 0; j < stripe.rows; ++j, colour += width) {
        now[0] = north[0] = 0;
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                for (int i = begin; i < end; ++i) now[size_t(i) + 1] = as_differences(colour[i]);
                for (size_t i = size_t(begin); i < size_t(end); ++i)
                    *to++ = zigzag_bytes(minus(now[i + 1], foretold(now[i], north[i + 1], north[i])));
            },
            [&](int begin, int end) {
                std::memcpy(&now[size_t(begin) + 1], &north[size_t(begin) + 1],
                            size_t(end - begin) * sizeof(uint32_t));
            });
        std::swap(north, now);
    }
}

void restore_colours(const Stripe& stripe, std::span<const uint32_t> residuals, uint32_t* colour) {
    const size_t width = size_t(stripe.width);
    std::vector<uint32_t> north(width + 1, 0), now(width + 1, 0);
    const uint32_t* from = residuals.data();
    for (int j = 0; j < stripe.rows; ++j, colour += width) {
        now[0] = north[0] = 0;
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                uint32_t west = now[size_t(begin)];
                for (size_t i = size_t(begin); i < size_t(end); ++i) {
                    west = plus(foretold(west, north[i + 1], north[i]), unzigzag_bytes(*from++)) & 0xffffff;
                    now[i + 1] = west;
                    colour[i] = as_colour(west);
                }
            },
            [&](int begin, int end) {
                std::memcpy(&now[size_t(begin) + 1], &north[size_t(begin) + 1],
                            size_t(end - begin) * sizeof(uint32_t));
            });
        std::swap(north, now);
    }
}

}  // namespace ppve
