#include "render/y4m.h"

#include <cmath>
#include <numeric>

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/y4m.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// BT.601, limited range, in 1/256.  The chroma weights are halved because they meet half the sum of four
// pixels (0..510): 56 * 510 is the largest product that 16 signed bits must hold.  Each chroma triple adds up
// to 0, so that grey stays grey.
#ifndef QS_RENDER_Y4M_WEIGHTS
#define QS_RENDER_Y4M_WEIGHTS
namespace render {
constexpr int kYr = 66, kYg = 129, kYb = 25;
constexpr int kUr = -19, kUg = -37, kUb = 56;
constexpr int kVr = 56, kVg = -47, kVb = -9;
}  // namespace render
#endif

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

uint8_t luma(const uint8_t* p) {
    return static_cast<uint8_t>(((kYr * p[0] + kYg * p[1] + kYb * p[2] + 128) >> 8) + 16);
}

// `half`: half the sums of the four pixels' channels, rounded up.
uint8_t chroma(const int* half, int r, int g, int b) {
    return static_cast<uint8_t>(((r * half[0] + g * half[1] + b * half[2] + 128) >> 8) + 128);
}

// The columns [begin, width) of a pair of rows; begin is even.
void convert_rest(const uint8_t* top, const uint8_t* bottom, size_t begin, size_t width, uint8_t* y_top,
                  uint8_t* y_bottom, uint8_t* u, uint8_t* v) {
    for (size_t x = begin; x < width; x += 2) {
        const size_t next = x + 1 < width ? x + 1 : x;
        for (size_t column : {x, next}) {
            y_top[column] = luma(top + 3 * column);
            y_bottom[column] = luma(bottom + 3 * column);
        }
        int half[3];
        for (size_t c = 0; c < 3; ++c)
            half[c] =
                (top[3 * x + c] + top[3 * next + c] + bottom[3 * x + c] + bottom[3 * next + c] + 1) >> 1;
        u[x / 2] = chroma(half, kUr, kUg, kUb);
        v[x / 2] = chroma(half, kVr, kVg, kVb);
    }
}

#if HWY_TARGET != HWY_SCALAR
namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::ScalableTag<uint8_t> kBytes;
using Words = hn::Repartition<uint16_t, decltype(kBytes)>;
using Signed = hn::RebindToSigned<Words>;
using WordVec = hn::Vec<Words>;
using SignedVec = hn::Vec<Signed>;

// One channel of a vector of pixels as 16-bit lanes: the even columns and the odd ones.
struct Channel {
    WordVec even, odd;
};

template <class ByteVec>
HWY_INLINE Channel split_columns(ByteVec bytes) {
    const WordVec pairs = hn::BitCast(Words(), bytes);
    return {hn::And(pairs, hn::Set(Words(), 0xff)), hn::ShiftRight<8>(pairs)};
}

HWY_INLINE WordVec luma_lanes(WordVec r, WordVec g, WordVec b) {
    const Words d;
    const auto sum = hn::Add(hn::Add(hn::Mul(r, hn::Set(d, kYr)), hn::Mul(g, hn::Set(d, kYg))),
                             hn::Add(hn::Mul(b, hn::Set(d, kYb)), hn::Set(d, 128)));
    return hn::Add(hn::ShiftRight<8>(sum), hn::Set(d, 16));
}

HWY_INLINE void store_luma(const Channel& r, const Channel& g, const Channel& b, uint8_t* out) {
    const auto even = luma_lanes(r.even, g.even, b.even);
    const auto odd = luma_lanes(r.odd, g.odd, b.odd);
    hn::StoreU(hn::BitCast(kBytes, hn::Or(even, hn::ShiftLeft<8>(odd))), kBytes, out);
}

HWY_INLINE SignedVec half_sum(const Channel& top, const Channel& bottom) {
    const auto sum = hn::Add(hn::Add(top.even, top.odd), hn::Add(bottom.even, bottom.odd));
    return hn::BitCast(Signed(), hn::ShiftRight<1>(hn::Add(sum, hn::Set(Words(), 1))));
}

HWY_INLINE void store_chroma(SignedVec r, SignedVec g, SignedVec b, int wr, int wg, int wb, uint8_t* out) {
    const Signed d;
    const auto weight = [&](int w) { return hn::Set(d, static_cast<int16_t>(w)); };
    const auto sum = hn::Add(hn::Add(hn::Mul(r, weight(wr)), hn::Mul(g, weight(wg))),
                             hn::Add(hn::Mul(b, weight(wb)), weight(128)));
    const hn::Rebind<uint8_t, Signed> bytes;
    hn::StoreU(hn::DemoteTo(bytes, hn::Add(hn::ShiftRight<8>(sum), weight(128))), bytes, out);
}

// The whole vectors of a pair of rows; returns the column where it stopped.
size_t convert_vectors(const uint8_t* top, const uint8_t* bottom, size_t width, uint8_t* y_top,
                       uint8_t* y_bottom, uint8_t* u, uint8_t* v) {
    const size_t lanes = hn::Lanes(kBytes);
    size_t x = 0;
    for (; x + lanes <= width; x += lanes) {
        hn::Vec<decltype(kBytes)> r, g, b;
        hn::LoadInterleaved3(kBytes, top + 3 * x, r, g, b);
        const Channel r0 = split_columns(r), g0 = split_columns(g), b0 = split_columns(b);
        hn::LoadInterleaved3(kBytes, bottom + 3 * x, r, g, b);
        const Channel r1 = split_columns(r), g1 = split_columns(g), b1 = split_columns(b);
        store_luma(r0, g0, b0, y_top + x);
        store_luma(r1, g1, b1, y_bottom + x);
        const auto hr = half_sum(r0, r1), hg = half_sum(g0, g1), hb = half_sum(b0, b1);
        store_chroma(hr, hg, hb, kUr, kUg, kUb, u + x / 2);
        store_chroma(hr, hg, hb, kVr, kVg, kVb, v + x / 2);
    }
    return x;
}
#endif

// Where the picture has an odd number of rows, `bottom` and `y_bottom` are the top ones of the last pair.
void convert_rows(const uint8_t* top, const uint8_t* bottom, size_t width, uint8_t* y_top, uint8_t* y_bottom,
                  uint8_t* u, uint8_t* v) {
#if HWY_TARGET == HWY_SCALAR
    const size_t done = 0;
#else
    const size_t done = convert_vectors(top, bottom, width, y_top, y_bottom, u, v);
#endif
    convert_rest(top, bottom, done, width, y_top, y_bottom, u, v);
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(convert_rows);

size_t yuv420_size(int width, int height) {
    const size_t w = static_cast<size_t>(width), h = static_cast<size_t>(height);
    return w * h + 2 * ((w + 1) / 2) * ((h + 1) / 2);
}

void rgb_to_yuv420(const uint8_t* rgb, int width, int height, uint8_t* planes) {
    const size_t w = static_cast<size_t>(width), h = static_cast<size_t>(height);
    const size_t chroma_width = (w + 1) / 2;
    uint8_t* u = planes + w * h;
    uint8_t* v = u + chroma_width * ((h + 1) / 2);
    for (size_t row = 0; row < h; row += 2) {
        const size_t below = row + 1 < h ? row + 1 : row;
        HWY_DYNAMIC_DISPATCH(convert_rows)
        (rgb + 3 * w * row, rgb + 3 * w * below, w, planes + w * row, planes + w * below,
         u + chroma_width * (row / 2), v + chroma_width * (row / 2));
    }
}

std::string y4m_header(int width, int height, double frames_per_s) {
    long numerator = std::lround(frames_per_s * 1000), denominator = 1000;
    const double ntsc = std::round(frames_per_s * 1.001);
    if (std::abs(frames_per_s - std::round(frames_per_s)) > 0.0005 && ntsc > 0 &&
        std::abs(frames_per_s - ntsc / 1.001) < 0.005)
        numerator = std::lround(ntsc) * 1000, denominator = 1001;
    const long divisor = std::gcd(numerator, denominator);
    return core::text("YUV4MPEG2 W%d H%d F%ld:%ld Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n", width, height,
                      numerator / divisor, denominator / divisor);
}

}  // namespace render
#endif
