#include "ppve/residuals.h"

#include <algorithm>
#include <cstring>

namespace ppve {

namespace {

uint32_t zigzag(uint32_t difference) {
    return difference << 1 ^ uint32_t(int32_t(difference) >> 31);
}

uint32_t unzigzag(uint32_t code) {
    return code >> 1 ^ (0 - (code & 1));
}

// Four signed numbers a pixel (the last one 0), two pixels at a time; one register, on any processor.
using Wide = int16_t __attribute__((vector_size(16)));
using Bytes = uint8_t __attribute__((vector_size(16)));
constexpr size_t kLanes = 4;  // of a pixel

Wide load(const int16_t* from) {
    Wide wide;
    std::memcpy(&wide, from, sizeof(wide));
    return wide;
}

// Two pixels' bytes as numbers from 0 to 255, and back.
Wide widened(uint64_t packed) {
    using Words = uint64_t __attribute__((vector_size(16)));
    constexpr Bytes kPlaces = {0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23};
    return reinterpret_cast<Wide>(
        __builtin_shuffle(reinterpret_cast<Bytes>(Words{packed, 0}), Bytes{}, kPlaces));
}

uint64_t narrowed(Wide wide) {
    using Words = uint64_t __attribute__((vector_size(16)));
    constexpr Bytes kPlaces = {0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30};
    return reinterpret_cast<Words>(
        __builtin_shuffle(reinterpret_cast<Bytes>(wide), reinterpret_cast<Bytes>(wide), kPlaces))[0];
}

// Modulo 256, from -128 to 127.
Wide wrapped(Wide wide) {
    return wide << 8 >> 8;
}

Wide greens(Wide colours) {
    constexpr Wide kPlaces = {1, 1, 1, 1, 5, 5, 5, 5}, kWhere = {-1, 0, -1, 0, -1, 0, -1, 0};
    return __builtin_shuffle(colours, kPlaces) & kWhere;
}

// 0x00BBGGRR as R - G, G, B - G, 0.
void as_differences(const uint32_t* colours, size_t count, int16_t* out) {
    for (size_t i = 0; i < count; i += 2) {
        uint64_t two = colours[i];
        if (i + 1 < count) two |= uint64_t(colours[i + 1]) << 32;
        const Wide wide = widened(two);
        // The last number is 0 whatever the byte is.
        constexpr Wide kColour = {-1, -1, -1, 0, -1, -1, -1, 0};
        const Wide differences = wrapped(wide - greens(wide)) & kColour;
        std::memcpy(out + kLanes * i, &differences, sizeof(Wide));
    }
}

void as_colours(const int16_t* differences, size_t count, uint32_t* out) {
    for (size_t i = 0; i < count; i += 2) {
        const Wide wide = load(differences + kLanes * i);
        const uint64_t two = narrowed(wide + greens(wide));
        out[i] = uint32_t(two);
        if (i + 1 < count) out[i + 1] = uint32_t(two >> 32);
    }
}

Wide least(Wide a, Wide b) {
    return a < b ? a : b;
}

Wide most(Wide a, Wide b) {
    return a > b ? a : b;
}

Wide foretold(Wide w, Wide n, Wide nw) {
    return most(least(w, n), least(most(w, n), w + (n - nw)));
}

// Rows of colours as differences, with one pixel more on the left, and one on the right for those who take
// two.
struct ColourRows {
    std::vector<int16_t> north, now;
    explicit ColourRows(size_t width) : north(kLanes * (width + 2), 0), now(north) {}

    int16_t* here(size_t i) { return &now[kLanes * (i + 1)]; }
    Wide west(size_t i) const { return load(&now[kLanes * i]); }
    Wide above(size_t i) const { return load(&north[kLanes * (i + 1)]); }
    Wide above_west(size_t i) const { return load(&north[kLanes * i]); }
    void fill_from_above(int begin, int end) {
        std::memcpy(here(size_t(begin)), &north[kLanes * (size_t(begin) + 1)],
                    size_t(end - begin) * kLanes * sizeof(int16_t));
    }
    void next_row() {
        std::swap(north, now);
        std::fill_n(now.begin(), kLanes, int16_t(0)), std::fill_n(north.begin(), kLanes, int16_t(0));
    }
};

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
    ColourRows rows(width);
    // One more, as two are written at a time.
    out.resize(stripe.mask->count() + 1);
    uint32_t* to = out.data();
    for (int j = 0; j < stripe.rows; ++j, colour += width, rows.next_row())
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                as_differences(colour + begin, size_t(end - begin), rows.here(size_t(begin)));
                for (size_t i = size_t(begin); i < size_t(end); i += 2) {
                    const Wide here = load(rows.here(i));
                    const Wide left =
                        wrapped(here - foretold(rows.west(i), rows.above(i), rows.above_west(i)));
                    const uint64_t two = narrowed(left << 1 ^ left >> 15);
                    std::memcpy(to + (i - size_t(begin)), &two, sizeof(two));
                }
                to += end - begin;
            },
            [&](int begin, int end) { rows.fill_from_above(begin, end); });
    out.pop_back();
}

void restore_colours(const Stripe& stripe, std::span<const uint32_t> residuals, uint32_t* colour) {
    const size_t width = size_t(stripe.width);
    ColourRows rows(width);
    const uint32_t* from = residuals.data();
    for (int j = 0; j < stripe.rows; ++j, colour += width, rows.next_row())
        stripe.mask->for_runs(
            j,
            [&](int begin, int end) {
                Wide west = rows.west(size_t(begin));
                for (size_t i = size_t(begin); i < size_t(end); ++i) {
                    const Wide code = widened(*from++);
                    const Wide left = (code >> 1) ^ -(code & 1);
                    west = wrapped(foretold(west, rows.above(i), rows.above_west(i)) + left);
                    std::memcpy(rows.here(i), &west, kLanes * sizeof(int16_t));
                }
                as_colours(rows.here(size_t(begin)), size_t(end - begin), colour + begin);
            },
            [&](int begin, int end) { rows.fill_from_above(begin, end); });
}

}  // namespace ppve
