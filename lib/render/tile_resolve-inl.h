// From a tile's samples to pixels of the frame.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_TILE_RESOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_TILE_RESOLVE_INL_H_
#undef RENDER_TILE_RESOLVE_INL_H_
#else
#define RENDER_TILE_RESOLVE_INL_H_
#endif

#include <hwy/highway.h>
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "render/tile_pixels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// `channels` values for each of `width` pixels; the usual width as a few moves instead of a call.
template <class T>
HWY_INLINE void copy_row(const T* from, size_t channels, int width, T* to) {
    if (width == kTileWidth) {
        std::memcpy(to, from, sizeof(T) * channels * kTileWidth);
    } else {
        std::memcpy(to, from, sizeof(T) * channels * size_t(width));
    }
}

// The pixels of a tile's row from `first` on.
HWY_INLINE void write_rgb_row(const uint32_t* packed, int first, int width, uint8_t* out) {
#if HWY_TARGET == HWY_SCALAR
    for (int x = first; x < first + width; ++x, out += 3) {
        out[0] = uint8_t(packed[x]), out[1] = uint8_t(packed[x] >> 8), out[2] = uint8_t(packed[x] >> 16);
    }
#else
    const hn::FixedTag<uint8_t, 16> d;
    alignas(16) static constexpr uint8_t kPick[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 3, 3, 3};
    const auto pick = hn::Load(d, kPick);
    uint8_t row[kTileWidth * 3 + 4];
    for (int x = 0; x < kTileWidth; x += 4) {
        const auto four = hn::Load(d, reinterpret_cast<const uint8_t*>(packed + x));
        hn::StoreU(hn::TableLookupBytes(four, pick), d, row + x * 3);
    }
    copy_row<uint8_t>(row + 3 * first, 3, width, out);
#endif
}

// The mean of the across x across samples of each pixel, byte by byte, to the nearest.
template <int kAcross>
HWY_INLINE void average(const uint32_t* samples, int first, int width, uint32_t* HWY_RESTRICT out) {
    constexpr uint32_t kCount = kAcross * kAcross, kHalves = 0x00010001u * (kCount / 2);
    constexpr int kShift = std::countr_zero(kCount);
    for (int x = 0; x < width; ++x) {
        // Two bytes at a time have room for their sums.
        uint32_t even = kHalves, odd = kHalves;
        for (int sy = 0; sy < kAcross; ++sy) {
            for (int sx = 0; sx < kAcross; ++sx) {
                const uint32_t sample = samples[sy * kTileWidth + first + x * kAcross + sx];
                even += sample & 0x00ff00ffu;
                odd += sample >> 8 & 0x00ff00ffu;
            }
        }
        out[x] = (even >> kShift & 0x00ff00ffu) | (odd >> kShift & 0x00ff00ffu) << 8;
    }
}

// The highest byte of a sample says what it shows; kNoSample is the background.
enum SampleMark : uint32_t { kNoSample = 0, kCoverSample = 1, kCoreSample = 2 };

// Mixed by what the samples are of.
inline void mix_pixels(const uint32_t* samples, int first, int width, const Look& look, uint32_t* out) {
    const int across = look.samples_across;
    for (int x = 0; x < width; ++x) {
        PixelSamples pixel{.count = static_cast<uint32_t>(across * across)};
        for (int sy = 0; sy < across; ++sy) {
            for (int sx = 0; sx < across; ++sx) {
                const uint32_t sample = samples[sy * kTileWidth + first + x * across + sx];
                const glm::u32vec3 colour(sample & 255u, sample >> 8 & 255u, sample >> 16 & 255u);
                if (sample >> 24 == kCoreSample) pixel.core_sum += colour, ++pixel.cores;
                if (sample >> 24 == kCoverSample) pixel.cover_sum += colour, ++pixel.covers;
            }
        }
        const MixedPixel mixed = mix(pixel, look);
        out[x] = mixed.rgb.r | uint32_t(mixed.rgb.g) << 8 | uint32_t(mixed.rgb.b) << 16 |
                 uint32_t(mixed.alpha) << 24;
    }
}

HWY_INLINE bool has_covers(const uint32_t* samples, const TileJob& job, int across) {
    uint32_t covers = 0;
    for (int y = 0; y < across; ++y)
        for (int x = job.left; x < job.right; ++x)
            covers += samples[y * kTileWidth + x] >> 24 == kCoverSample;
    return covers > 0;
}

// Writes one row of the frame from the tile's rows of samples.
HWY_INLINE void write_row(const Look& look, const TileJob& job, const uint32_t* colours, const float* depths,
                          size_t at, Frame& frame) {
    const int across = look.samples_across, width = (job.right - job.left) / across;
    if (across == 1 && !look.has_alpha()) {
        std::memcpy(frame.depth.data() + at, depths + job.left, sizeof(float) * size_t(width));
        return write_rgb_row(colours, job.left, width, frame.rgb.data() + at * 3);
    }
    const float* depth = depths + look.depth_sample() * (kTileWidth + 1) + job.left;
    for (int x = 0; x < width; ++x) frame.depth[at + size_t(x)] = depth[x * across];
    alignas(64) uint32_t row[kTileWidth] = {};
    if (look.has_alpha() || has_covers(colours, job, across)) {
        mix_pixels(colours, job.left, width, look, row);
        for (int x = 0; look.has_alpha() && x < width; ++x)
            frame.alpha[at + size_t(x)] = uint8_t(row[x] >> 24);
    } else if (across == 2) {
        average<2>(colours, job.left, width, row);
    } else {
        average<4>(colours, job.left, width, row);
    }
    write_rgb_row(row, 0, width, frame.rgb.data() + at * 3);
}

// One row of the tile, where its blocks are unproven; `at`: its first pixel in the frame.
inline void write_unproven(const Look& look, const TileJob& job, int y, const float* depths,
                           const uint32_t* colours, size_t at, Frame& frame) {
    for (int x = job.left; x < job.right; ++x, ++at) {
        if (!job.map->is_unproven(job.x0 + x, job.y0 + y)) continue;
        frame.depth[at] = depths[x];
        if (look.has_alpha()) frame.alpha[at] = colours[x] >> 24 == kNoSample ? look.background_alpha : 255;
        for (size_t c = 0; c < 3; ++c) frame.rgb[3 * at + c] = uint8_t(colours[x] >> (8 * c));
    }
}

// Shades the tile's samples and writes its pixels out.
template <class Pixel>
void resolve(const SetupParams& params, const TileJob& job, float* state, Frame& frame) {
    const F d;
    const Look& look = params.options.look;
    const glm::u8vec3 background = look.background;
    // A pixel of one sample is not mixed.
    const bool tells_covers = look.samples_across > 1;
    const auto core = hn::Set(U(), kCoreSample << 24);
    const auto cover = tells_covers ? hn::Set(U(), kCoverSample << 24) : core;
    const auto no_colour =
        hn::Set(U(), uint32_t(background.r) | uint32_t(background.g) << 8 | uint32_t(background.b) << 16);
    const V no_depth = hn::Set(d, std::numeric_limits<float>::infinity());
    const V unit = hn::Set(d, static_cast<float>(params.options.depth_unit));
    alignas(64) uint32_t colours[kBlockSize * kTileWidth], block_colours[kBlockPixels];
    alignas(64) float depths[kBlockSize * kTileWidth], block_depths[kBlockPixels];
    for (int y = job.top / kBlockSize * kBlockSize; y < job.bottom; y += kBlockSize) {
        for (int x = job.left / kBlockSize * kBlockSize; x < job.right; x += kBlockSize) {
            const float* block = block_at<Pixel>(state, x / kBlockSize, y / kBlockSize);
            for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d)) {
                const float* at = block + lane;
                const V order = hn::Load(d, at);
                const M drawn = hn::Gt(order, hn::Set(d, kNothing));
                const V depth = hn::Div(unit, Pixel::inverse_depth(at));
                V depth_behind = no_depth;
                auto colour_behind = no_colour;
                if constexpr (kIsLimited<Pixel>) {
                    if (job.triangles) {
                        const size_t triangle = block_index(x, y) * kBlockPixels + lane;
                        const V w = hn::Load(d, job.triangles->w + triangle);
                        const auto colour = hn::Or(hn::Load(U(), job.triangles->colour + triangle), core);
                        const M is_there = hn::Gt(w, hn::Set(d, kNoTriangle));
                        depth_behind = hn::IfThenElse(is_there, hn::Div(unit, w), no_depth);
                        colour_behind = hn::IfThenElse(hn::RebindMask(U(), is_there), colour, no_colour);
                    }
                }
                hn::Store(hn::IfThenElse(drawn, depth, depth_behind), d, block_depths + lane);
                const auto mark = hn::IfThenElse(
                    hn::RebindMask(U(), hn::Lt(order, hn::Set(d, kLeastCoreOrder))), cover, core);
                const auto shaded = hn::Or(Pixel::shade(params, at), mark);
                hn::Store(hn::IfThenElse(hn::RebindMask(U(), drawn), shaded, colour_behind), U(),
                          block_colours + lane);
            }
            for (int row = 0; row < kBlockSize; ++row) {
                std::memcpy(depths + row * kTileWidth + x, block_depths + row * kBlockSize,
                            sizeof(float) * 4);
                std::memcpy(colours + row * kTileWidth + x, block_colours + row * kBlockSize,
                            sizeof(uint32_t) * 4);
            }
        }
        const int across = look.samples_across;
        for (int row = std::max(job.top - y, 0); row < std::min(job.bottom - y, kBlockSize); row += across) {
            const size_t at = job.frame_at + size_t((y + row - job.top) / across) * size_t(frame.width);
            if (job.map && job.map->is_repeated()) {
                write_unproven(look, job, y + row, depths + row * kTileWidth, colours + row * kTileWidth, at,
                               frame);
                continue;
            }
            write_row(look, job, colours + row * kTileWidth, depths + row * kTileWidth, at, frame);
        }
    }
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
