#include "render/tile.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "render/tile_triangles.h"

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/tile.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/shading-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// A block, or an equal part of one.
using F = hn::CappedTag<float, kBlockPixels>;
using V = hn::Vec<F>;
using M = hn::Mask<F>;
using U = hn::RebindToUnsigned<F>;

constexpr int kBlocksAcross = kTileWidth / kBlockSize;

// Inverse depth of what nothing was drawn on: farther than infinity, so that the first fragment always starts
// a pixel afresh and no other plane needs clearing.
constexpr float kNothing = -3.0e38f;
constexpr float kFarthestCover = -1.0e38f;

// Pixel offsets of a block's lanes.
alignas(64) constexpr float kLaneX[kBlockPixels] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
alignas(64) constexpr float kLaneY[kBlockPixels] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

// What one splat puts into the lanes of one vector.
struct Fragment {
    M inside;
    V w;     // inverse depth
    V order;  // the same, or what else grows with nearness
    V t;     // 1 in the splat's middle, kEdge at its rim
    V push;  // R of depth as inverse depth
};

// What is the same for all of a splat's fragments.
struct Surface {
    float nx, ny, nz;
    uint32_t colour;
    float least_w, most_w;  // as in SetupParams
};

// The nearest splat has the pixel, near being pushed back by up to R towards the rim ("hill"), so
// that of overlapping splats the one with the nearer centre wins.  The result does not depend on the order.
struct Nearest {
    enum Plane { kKey, kDepth, kColour, kPlanes };
    static constexpr int kFront = kKey, kProof = kDepth;
    static constexpr bool kBlends = false;

    const U du;
    hn::Vec<U> colour;

    HWY_INLINE explicit Nearest(const Surface& surface) : colour(hn::Set(U(), surface.colour)) {}

    HWY_INLINE void put(const Fragment& f, float* HWY_RESTRICT at) const {
        const F d;
        const V hill = hn::Mul(f.push, hn::Sub(hn::Set(d, 1.0f), f.t));
        const V key = hn::Sub(f.order, hill);
        const V old = hn::Load(d, at + kKey * kBlockPixels);
        const M wins = hn::And(f.inside, hn::Gt(key, old));
        store_where(wins, key, at + kKey * kBlockPixels);
        store_where(wins, f.w, at + kDepth * kBlockPixels);
        store_where(wins, hn::BitCast(d, colour), at + kColour * kBlockPixels);
    }

    HWY_INLINE static void store_where(M mask, V value, float* HWY_RESTRICT at) {
        const F d;
        hn::Store(hn::IfThenElse(mask, value, hn::Load(d, at)), d, at);
    }

    HWY_INLINE static V inverse_depth(const float* at) { return hn::Load(F(), at + kDepth * kBlockPixels); }
    HWY_INLINE static hn::Vec<U> shade(const SetupParams&, const float* at) {
        return hn::BitCast(U(), hn::Load(F(), at + kColour * kBlockPixels));
    }
};

// Splats within R of depth of the nearest so far are blended with weight t^2; what is nearer by more
// starts the pixel afresh, what is farther by more is left out.  Depends on the order.  The depth is that of
// the splat of largest weight and not a mean: a point between two sheets is on neither.
template <bool kNormals, bool kColours>
struct Blend {
    enum Plane { kFront, kWeight, kLargest, kDepth, kPayload };
    static constexpr int kColourPlane = kPayload + (kNormals ? 3 : 0);
    static constexpr int kPlanes = kColourPlane + (kColours ? 3 : 0);
    static constexpr int kProof = kWeight;
    static constexpr bool kBlends = true;
    static_assert(kPlanes <= kMaxPlanes);

    V nx, ny, nz;
    Rgb<V> colour;

    HWY_INLINE explicit Blend(const Surface& surface)
        : nx(hn::Set(F(), surface.nx)), ny(hn::Set(F(), surface.ny)), nz(hn::Set(F(), surface.nz)) {
        const F d;
        colour = {hn::Set(d, static_cast<float>(surface.colour & 255u)),
                  hn::Set(d, static_cast<float>(surface.colour >> 8 & 255u)),
                  hn::Set(d, static_cast<float>(surface.colour >> 16 & 255u))};
    }

    HWY_INLINE void put(const Fragment& f, float* HWY_RESTRICT at) const {
        const F d;
        const V front = hn::Load(d, at + kFront * kBlockPixels);
        const V nearer_by = hn::Sub(f.order, front);
        const M afresh = hn::And(f.inside, hn::Gt(nearer_by, f.push));
        const M counts = hn::And(f.inside, hn::Ge(nearer_by, hn::Neg(f.push)));
        const V weight = hn::IfThenElseZero(counts, hn::Mul(f.t, f.t));
        hn::Store(hn::IfThenElse(counts, hn::Max(f.order, front), front), d, at + kFront * kBlockPixels);
        add(afresh, weight, at + kWeight * kBlockPixels);
        const V largest = hn::IfThenZeroElse(afresh, hn::Load(d, at + kLargest * kBlockPixels));
        const M leads = hn::And(counts, hn::Or(afresh, hn::Gt(weight, largest)));
        hn::Store(hn::Max(largest, weight), d, at + kLargest * kBlockPixels);
        hn::Store(hn::IfThenElse(leads, f.w, hn::Load(d, at + kDepth * kBlockPixels)), d, at + kDepth * kBlockPixels);
        if constexpr (kNormals) {
            add(afresh, hn::Mul(weight, nx), at + (kPayload + 0) * kBlockPixels);
            add(afresh, hn::Mul(weight, ny), at + (kPayload + 1) * kBlockPixels);
            add(afresh, hn::Mul(weight, nz), at + (kPayload + 2) * kBlockPixels);
        }
        if constexpr (kColours) {
            add(afresh, hn::Mul(weight, colour.r), at + (kColourPlane + 0) * kBlockPixels);
            add(afresh, hn::Mul(weight, colour.g), at + (kColourPlane + 1) * kBlockPixels);
            add(afresh, hn::Mul(weight, colour.b), at + (kColourPlane + 2) * kBlockPixels);
        }
    }

    HWY_INLINE static void add(M afresh, V value, float* HWY_RESTRICT at) {
        const F d;
        hn::Store(hn::Add(hn::IfThenZeroElse(afresh, hn::Load(d, at)), value), d, at);
    }

    HWY_INLINE static V inverse_depth(const float* at) {
        return hn::Load(F(), at + kDepth * kBlockPixels);
    }

    HWY_INLINE static hn::Vec<U> shade(const SetupParams& params, const float* at) {
        const F d;
        V nx = hn::Zero(d), ny = hn::Zero(d), nz = hn::Zero(d);
        if constexpr (kNormals) {
            nx = hn::Load(d, at + (kPayload + 0) * kBlockPixels);
            ny = hn::Load(d, at + (kPayload + 1) * kBlockPixels);
            nz = hn::Load(d, at + (kPayload + 2) * kBlockPixels);
            const V squares = hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz));
            // Opposite normals may cancel to nothing; the pixel is then left with ambient light.
            const V inverse = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(hn::Max(squares, hn::Set(d, 1.0e-30f))));
            nx = hn::Mul(nx, inverse), ny = hn::Mul(ny, inverse), nz = hn::Mul(nz, inverse);
        }
        const V grey = hn::Set(d, kGreyMaterial);
        Rgb<V> material{grey, grey, grey};
        if constexpr (kColours) {
            const V inverse = hn::Div(hn::Set(d, 1.0f), hn::Load(d, at + kWeight * kBlockPixels));
            material.r = hn::Mul(hn::Load(d, at + (kColourPlane + 0) * kBlockPixels), inverse);
            material.g = hn::Mul(hn::Load(d, at + (kColourPlane + 1) * kBlockPixels), inverse);
            material.b = hn::Mul(hn::Load(d, at + (kColourPlane + 2) * kBlockPixels), inverse);
        }
        return shade_points(d, params.options.look.shade, params.light, nx, ny, nz, material);
    }
};

// A pixel that takes only what is between the view's near and far, and in front of its triangle.  Of several
// samples a cover is in front of none, as it is in front of no core: a triangle is nothing but core.
template <class Pixel>
struct Limited : Pixel {
    static constexpr int kLimit = Pixel::kPlanes, kPlanes = Pixel::kPlanes + 1;
    static_assert(kPlanes <= kMaxPlanes);

    V least_w, most_w;

    HWY_INLINE explicit Limited(const Surface& surface)
        : Pixel(surface), least_w(hn::Set(F(), surface.least_w)), most_w(hn::Set(F(), surface.most_w)) {}

    HWY_INLINE void put(const Fragment& f, float* HWY_RESTRICT at) const {
        Fragment shown = f;
        const M in_front = hn::Gt(f.order, hn::Load(F(), at + kLimit * kBlockPixels));
        const M in_range = hn::And(hn::Ge(f.w, least_w), hn::Le(f.w, most_w));
        shown.inside = hn::And(f.inside, hn::And(in_range, in_front));
        Pixel::put(shown, at);
    }
};

// A pixel that may lack a triangle at its plane kHidden, or farther away.  See hide().
template <class Pixel>
struct Doubtful : Limited<Pixel> {
    static constexpr int kHidden = Limited<Pixel>::kPlanes, kPlanes = Limited<Pixel>::kPlanes + 1;
    static_assert(kPlanes <= kMaxPlanes);

    HWY_INLINE explicit Doubtful(const Surface& surface) : Limited<Pixel>(surface) {}

    HWY_INLINE void put(const Fragment& f, float* HWY_RESTRICT at) const {
        const F d;
        Limited<Pixel>::put(f, at);
        const V hidden = hn::Load(d, at + kHidden * kBlockPixels);
        const M reaches = hn::And(hn::Le(f.order, hidden), hn::Gt(hn::Add(f.order, f.push), hidden));
        const V proof = hn::Load(d, at + Pixel::kProof * kBlockPixels);
        hn::Store(hn::IfThenElse(hn::And(f.inside, reaches), hn::NaN(d), proof), d,
                  at + Pixel::kProof * kBlockPixels);
    }
};

template <class Pixel>
inline constexpr bool kIsLimited = false;
template <class Pixel>
inline constexpr bool kIsLimited<Limited<Pixel>> = true;
template <class Pixel>
inline constexpr bool kIsLimited<Doubtful<Pixel>> = true;
template <class Pixel>
inline constexpr bool kIsDoubtful = false;
template <class Pixel>
inline constexpr bool kIsDoubtful<Doubtful<Pixel>> = true;

// What a splat covers: with layers its core counts as nearer than the cover of any splat, the rest of the
// ellipsoid, wherever they are.
enum class Shape { square, outline, layers };

// The order of covers: negative, the depth instead of its inverse.
template <class Pixel>
HWY_INLINE void put_layers(const Pixel& pixel, const Fragment& f, M core, float* HWY_RESTRICT at) {
    const F d;
    const V depth = hn::Div(hn::Set(d, 1.0f), f.w);
    Fragment layered = f;
    layered.order = hn::IfThenElse(core, f.w, hn::Max(hn::Neg(depth), hn::Set(d, kFarthestCover)));
    layered.push = hn::IfThenElse(core, f.push, hn::Mul(hn::Mul(f.push, depth), depth));
    pixel.put(layered, at);
}

template <class Pixel>
HWY_INLINE float* block_at(float* state, int bx, int by) {
    return state + size_t(by * kBlocksAcross + bx) * Pixel::kPlanes * kBlockPixels;
}

HWY_INLINE size_t block_index(int x, int y) {
    return size_t(y / kBlockSize * kBlocksAcross + x / kBlockSize);
}

// Samples one splat at all pixels of the tile that its record names.  Blocks that turn out to be empty are
// not skipped: a test in the loop cost 12 % at 3 px and 40 % at 12 px, being mispredicted.
template <class Pixel, Shape kShape>
HWY_INLINE void draw_splat(const SplatRecord& r, const SetupParams& params, const TileJob& job,
                           float* HWY_RESTRICT state) {
    const F d;
    constexpr size_t kLanes = hn::MaxLanes(F());
    const int x0 = std::max<int>(r.x0, job.x0) - job.x0, x1 = std::min<int>(r.x1 - job.x0, kTileWidth - 1);
    const int y0 = std::max<int>(r.y0, job.y0) - job.y0, y1 = std::min<int>(r.y1 - job.y0, kTileHeight - 1);
    if (x1 < x0 || y1 < y0) return;  // what the splat's tiles were told by is larger than the splat
    const int bx0 = x0 / kBlockSize, bx1 = x1 / kBlockSize;
    const int by0 = y0 / kBlockSize, by1 = y1 / kBlockSize;
    // Offset of the tile's first pixel.
    const float tile_dx = static_cast<float>(job.x0 - r.x0), tile_dy = static_cast<float>(job.y0 - r.y0);
    const V one = hn::Set(d, 1.0f), edge = hn::Set(d, kEdge);
    const Pixel pixel(Surface{r.nx, r.ny, r.nz, r.colour, params.least_w, params.most_w});
    const V core_a = hn::Set(d, static_cast<float>(r.core_a) * (1 / kCoreScale));
    const V core_b = hn::Set(d, static_cast<float>(r.core_b) * (1 / kCoreScale));
    Fragment f;
    f.push = hn::Set(d, r.push);
    for (size_t lane = 0; lane < kBlockPixels; lane += kLanes) {
        const V lane_x = hn::Load(d, kLaneX + lane), lane_y = hn::Load(d, kLaneY + lane);
        const V lane_a = hn::Add(hn::Mul(hn::Set(d, r.l1), lane_x), hn::Mul(hn::Set(d, r.l2), lane_y));
        const V lane_b = hn::Mul(hn::Set(d, r.l3), lane_y);
        const V lane_w = hn::Add(hn::Mul(hn::Set(d, r.w_dx), lane_x), hn::Mul(hn::Set(d, r.w_dy), lane_y));
        for (int by = by0; by <= by1; ++by) {
            const float dy = (tile_dy + static_cast<float>(by * kBlockSize)) + r.dy0;
            const V b = hn::Add(lane_b, hn::Set(d, r.l3 * dy));
            const V rest = hn::Sub(one, hn::Mul(b, b));
            float* at = block_at<Pixel>(state, bx0, by) + lane;
            for (int bx = bx0; bx <= bx1; ++bx, at += Pixel::kPlanes * kBlockPixels) {
                const float dx = (tile_dx + static_cast<float>(bx * kBlockSize)) + r.dx0;
                const V a = hn::Add(lane_a, hn::Set(d, r.l1 * dx + r.l2 * dy));
                if constexpr (kShape == Shape::square) {
                    f.t = one;
                    f.inside = hn::Le(hn::Max(hn::Abs(a), hn::Abs(b)), one);
                } else {
                    f.t = hn::Sub(rest, hn::Mul(a, a));
                    f.inside = hn::Ge(f.t, edge);
                }
                f.order = f.w = hn::Add(lane_w, hn::Set(d, r.w + (r.w_dx * dx + r.w_dy * dy)));
                if constexpr (kShape == Shape::layers) {
                    const V s = hn::Add(hn::Mul(core_a, a), hn::Mul(core_b, b));
                    put_layers(pixel, f, hn::Ge(hn::Sub(f.t, hn::Mul(s, s)), hn::Set(d, kCoreEdge)), at);
                } else {
                    pixel.put(f, at);
                }
            }
        }
    }
}

// Ray d = (dx, dy, 1) against the ellipsoid at p with R = 1, c = rho^2, A = c + (1 - c) n n^T:
// hit if d.A.d >= c |m|^2 + (1 - c) |n x m|^2 with m = d x p.  No difference of squares, as in the set-up.
template <class Pixel>
void draw_near_splat(const NearSplat& s, const SetupParams& params, const TileJob& job,
                     float* HWY_RESTRICT state) {
    const F d;
    const float c = s.flatness_squared, g = 1.0f - c;
    const float np = s.nx * s.px + s.ny * s.py + s.nz * s.pz;
    const float ux = c * s.px + g * np * s.nx, uy = c * s.py + g * np * s.ny, uz = c * s.pz + g * np * s.nz;
    const float pup = c * (s.px * s.px + s.py * s.py + s.pz * s.pz) + g * np * np;
    const bool eye_inside = pup <= c;
    const V inverse_focal = hn::Set(d, static_cast<float>(1.0 / params.view.focal_px));
    const glm::dvec2 principal = params.view.principal();
    const float centre_x = static_cast<float>(principal.x - 0.5);
    const float centre_y = static_cast<float>(principal.y - 0.5);
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), largest = hn::Set(d, 1.0e6f);
    const V vc = hn::Set(d, c), vg = hn::Set(d, g);
    const Pixel pixel(Surface{s.nx, s.ny, s.nz, s.colour, params.least_w, params.most_w});
    Fragment f;
    f.t = hn::Set(d, kEdge);  // of least weight, and pushed back by all of R: gives way to whole splats
    // Whole blocks of the part of the tile that the splat may touch.
    const int x0 = std::max(s.x0 - job.x0, job.left) / kBlockSize * kBlockSize;
    const int y0 = std::max(s.y0 - job.y0, job.top) / kBlockSize * kBlockSize;
    const int x1 = std::min(s.x1 - job.x0, job.right - 1), y1 = std::min(s.y1 - job.y0, job.bottom - 1);
    for (int y = y0; y <= y1; y += kBlockSize) {
        for (int x = x0; x <= x1; x += kBlockSize) {
            for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d)) {
                const V px = hn::Add(hn::Load(d, kLaneX + lane), hn::Set(d, float(job.x0 + x) - centre_x));
                const V py = hn::Add(hn::Load(d, kLaneY + lane), hn::Set(d, float(job.y0 + y) - centre_y));
                const V dx = hn::Mul(px, inverse_focal), dy = hn::Mul(py, inverse_focal);
                const V mx = hn::Sub(hn::Mul(dy, hn::Set(d, s.pz)), hn::Set(d, s.py));
                const V my = hn::Sub(hn::Set(d, s.px), hn::Mul(dx, hn::Set(d, s.pz)));
                const V mz = hn::Sub(hn::Mul(dx, hn::Set(d, s.py)), hn::Mul(dy, hn::Set(d, s.px)));
                const auto dot = [&](V ax, V ay, V az, V bx, V by, V bz) HWY_ATTR {
                    return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
                };
                const V nx = hn::Set(d, s.nx), ny = hn::Set(d, s.ny), nz = hn::Set(d, s.nz);
                const V kx = hn::Sub(hn::Mul(ny, mz), hn::Mul(nz, my));
                const V ky = hn::Sub(hn::Mul(nz, mx), hn::Mul(nx, mz));
                const V kz = hn::Sub(hn::Mul(nx, my), hn::Mul(ny, mx));
                const V nd = dot(nx, ny, nz, dx, dy, one);
                const V dad =
                    hn::Add(hn::Mul(vc, dot(dx, dy, one, dx, dy, one)), hn::Mul(vg, hn::Mul(nd, nd)));
                const V miss = hn::Add(hn::Mul(vc, dot(mx, my, mz, mx, my, mz)),
                                       hn::Mul(vg, dot(kx, ky, kz, kx, ky, kz)));
                const V du = dot(dx, dy, one, hn::Set(d, ux), hn::Set(d, uy), hn::Set(d, uz));
                const V chord = hn::Sub(hn::Mul(dad, hn::Set(d, 1.00002f)), miss);  // grown, as the set-up's
                V w;  // inverse depth in units of 1/R
                if (eye_inside) {
                    // Where the ray leaves the ellipsoid: the least harm to what else is there.
                    const V root = hn::Sqrt(hn::Max(hn::Mul(vc, chord), zero));
                    w = hn::Div(dad, hn::Max(hn::Add(du, root), hn::Set(d, 1.0e-30f)));
                    f.inside = hn::Ge(dad, zero);
                } else {
                    w = hn::Div(du, hn::Set(d, pup));
                    f.inside = hn::And(hn::Ge(chord, zero), hn::Gt(du, zero));
                }
                w = hn::Min(w, largest);
                f.order = f.w = hn::Mul(w, hn::Set(d, s.inverse_radius));
                f.push = hn::Mul(f.w, hn::Div(w, hn::Add(one, w)));
                pixel.put(f, block_at<Pixel>(state, x / kBlockSize, y / kBlockSize) + lane);
            }
        }
    }
}

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
void mix_pixels(const uint32_t* samples, int first, int width, const Look& look, uint32_t* out) {
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
void write_unproven(const Look& look, const TileJob& job, int y, const float* depths, const uint32_t* colours, size_t at,
                    Frame& frame) {
    for (int x = job.left; x < job.right; ++x, ++at) {
        if (!job.map->is_unproven(job.x0 + x, job.y0 + y)) continue;
        frame.depth[at] = depths[x];
        if (look.has_alpha())
            frame.alpha[at] = colours[x] >> 24 == kNoSample ? look.background_alpha : 255;
        for (size_t c = 0; c < 3; ++c) frame.rgb[3 * at + c] = uint8_t(colours[x] >> (8 * c));
    }
}

// Shades the tile's samples and writes its pixels out.
template <class Pixel>
void resolve(const SetupParams& params, const TileJob& job, float* state, Frame& frame) {
    const F d;
    const Look& look = params.options.look;
    const glm::u8vec3 background = look.background;
    const auto cover = hn::Set(U(), kCoverSample << 24), core = hn::Set(U(), kCoreSample << 24);
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
                const auto mark =
                    hn::IfThenElse(hn::RebindMask(U(), hn::Lt(order, hn::Zero(d))), cover, core);
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
                write_unproven(look, job, y + row, depths + row * kTileWidth, colours + row * kTileWidth, at, frame);
                continue;
            }
            write_row(look, job, colours + row * kTileWidth, depths + row * kTileWidth, at, frame);
        }
    }
}

template <class Pixel>
void clear(const SetupParams& params, const TileJob& job, float* state) {
    const F d;
    for (int block = 0; block < kBlocksAcross * (kTileHeight / kBlockSize); ++block) {
        float* at = state + size_t(block) * Pixel::kPlanes * kBlockPixels;
        for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d))
            hn::Store(hn::Set(d, kNothing), d, at + lane);
        if constexpr (kIsLimited<Pixel>) {
            const V lead = hn::Set(d, params.triangle_lead);
            for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d)) {
                const V limit =
                    job.triangles ? hn::Mul(hn::Load(d, job.triangles->w + block * kBlockPixels + lane), lead)
                                  : hn::Set(d, kNothing);
                hn::Store(limit, d, at + Pixel::kLimit * kBlockPixels + lane);
            }
        }
    }
}

// Blocks that reach into the raster, each by its offset in the tile.
template <class Body>
HWY_INLINE void for_blocks(const TileJob& job, const Body& body) {
    for (int y = job.top / kBlockSize * kBlockSize; y < job.bottom; y += kBlockSize)
        for (int x = job.left / kBlockSize * kBlockSize; x < job.right; x += kBlockSize) body(x, y);
}

// Where something is hidden, pixels begin as if the nearest of it had been drawn already, but with what is no
// number for what it looks like.  Say no fragment of what is hidden has w + push above the limit, and take
// any order in which it might have come between the others.  A fragment that starts such a pixel afresh would
// have done so with the hidden ones, too, which have no larger w than the limit.  From then on both pixels
// are the same: w is beyond the limit, so a hidden fragment would not have counted.  Whereas one that is not
// started afresh stays no number.  With Nearest the same goes for the key, which is below w.
//
// Among what is hidden there may be triangles; none has w above the limit either.  A triangle that is drawn
// and is nearer than that hides all of them, and what else is hidden: the pixel needs no other proof.
// Elsewhere a hidden triangle pushes back fragments up to some w, at most the limit times the triangles'
// lead.  So that takes the limit's place.  A fragment up to there may be drawn where it should be pushed
// back, which does no harm while the pixel is no number, nor later, unless it counts; then it reaches beyond
// there by its push, and the pixel becomes no number again (Doubtful).  With Nearest it can't count: its key
// is below that of what started the pixel.
template <class Pixel>
void hide(const SetupParams& params, const TileJob& job, float* limits, float* state) {
    const F d;
    for_blocks(job, [&](int x, int y) HWY_ATTR {
        const int in_x = std::max(x, job.left), in_y = std::max(y, job.top);  // in the raster
        const float limit = job.map->limit(job.x0 + in_x, job.y0 + in_y);
        limits[block_index(x, y)] = limit;
        if (!(limit > 0) && !kIsDoubtful<Pixel>) return;
        float* at = block_at<Pixel>(state, x / kBlockSize, y / kBlockSize);
        const float hidden = params.options.has_triangles ? limit * params.triangle_lead : limit;
        for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d), at += hn::Lanes(d)) {
            M is_lacking = hn::Gt(hn::Set(d, limit), hn::Zero(d));
            if (job.triangles) {
                const V w = hn::Load(d, job.triangles->w + block_index(x, y) * kBlockPixels + lane);
                is_lacking = hn::And(is_lacking, hn::Le(w, hn::Set(d, limit)));
            }
            const V front = hn::IfThenElse(is_lacking, hn::Set(d, hidden), hn::Set(d, kNothing));
            hn::Store(front, d, at + Pixel::kFront * kBlockPixels);
            hn::Store(hn::IfThenElseZero(is_lacking, hn::NaN(d)), d, at + Pixel::kProof * kBlockPixels);
            if constexpr (kIsDoubtful<Pixel>) hn::Store(front, d, at + Pixel::kHidden * kBlockPixels);
        }
    });
}

// Marks the blocks where a pixel of the raster was never started afresh.
template <class Pixel>
void prove(const TileJob& job, const float* limits, float* state) {
    const F d;
    for_blocks(job, [&](int x, int y) HWY_ATTR {
        if (!(limits[block_index(x, y)] > 0)) return;
        const float* at =
            block_at<Pixel>(state, x / kBlockSize, y / kBlockSize) + Pixel::kProof * kBlockPixels;
        for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d)) {
            const V px = hn::Add(hn::Load(d, kLaneX + lane), hn::Set(d, float(x)));
            const V py = hn::Add(hn::Load(d, kLaneY + lane), hn::Set(d, float(y)));
            const M in_x =
                hn::And(hn::Ge(px, hn::Set(d, float(job.left))), hn::Lt(px, hn::Set(d, float(job.right))));
            const M in_y =
                hn::And(hn::Ge(py, hn::Set(d, float(job.top))), hn::Lt(py, hn::Set(d, float(job.bottom))));
            if (!hn::AllFalse(d, hn::And(hn::And(in_x, in_y), hn::IsNaN(hn::Load(d, at + lane)))))
                job.map->mark_unproven(job.x0 + std::max(x, job.left), job.y0 + std::max(y, job.top));
        }
    });
}

// Chunks are small and apart, and another processor may have filled them.
HWY_INLINE void fetch_ahead(const TileRun& run) {
    constexpr uint32_t kLine = 16;
    for (uint32_t at = 0; at < 4 * run.count; at += kLine) {
        hwy::Prefetch(run.chunk->place + at);
        hwy::Prefetch(run.chunk->facing + at);
    }
}

template <class Pixel, Shape kShape>
void draw_pixels(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    clear<Pixel>(params, job, scratch.state);
    const bool lacks_hidden = job.map && !job.map->is_repeated();
    if (lacks_hidden) hide<Pixel>(params, job, scratch.limits, scratch.state);
    for (const NearSplat& splat : job.near_splats) draw_near_splat<Pixel>(splat, params, job, scratch.state);
    for (const TileRun& run : job.runs) {
        if (&run != &job.runs.back()) fetch_ahead((&run)[1]);
        // No near splats here: they were found when the splats were sorted.
        const size_t count =
            set_up_splats(params, *run.chunk, *run.colours, run.count, scratch.records, scratch.near_splats);
        for (size_t i = 0; i < count; ++i)
            draw_splat<Pixel, kShape>(scratch.records[i], params, job, scratch.state);
    }
    if (lacks_hidden) prove<Pixel>(job, scratch.limits, scratch.state);
    resolve<Pixel>(params, job, scratch.state, frame);
}

template <class Pixel, Shape kShape>
void draw_and_shade(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    if constexpr (Pixel::kBlends && kShape == Shape::outline) {
        const bool lacks_triangles = params.options.has_triangles && job.map && !job.map->is_repeated();
        if (lacks_triangles) return draw_pixels<Doubtful<Pixel>, kShape>(params, job, scratch, frame);
    }
    if (params.has_limits() || job.triangles)
        return draw_pixels<Limited<Pixel>, kShape>(params, job, scratch, frame);
    draw_pixels<Pixel, kShape>(params, job, scratch, frame);
}

template <class Pixel>
void draw_outlines(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    if (params.has_cores()) return draw_and_shade<Pixel, Shape::layers>(params, job, scratch, frame);
    draw_and_shade<Pixel, Shape::outline>(params, job, scratch, frame);
}

const char* name_of_target() {
    return hwy::TargetName(HWY_TARGET);
}

void draw_tile(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    const SplatterOptions& options = params.options;
    // Without splats they are drawn alike, as the cheapest.
    const bool has_splats = !job.runs.empty() || !job.near_splats.empty();
    if (options.kind == SplatKind::square || !has_splats)
        return draw_and_shade<Nearest, Shape::square>(params, job, scratch, frame);
    if (options.kind != SplatKind::smooth) return draw_outlines<Nearest>(params, job, scratch, frame);
    const ShadingNeeds needs = needs_of(options);
    if (!needs.normals) {
        return needs.colours ? draw_outlines<Blend<false, true>>(params, job, scratch, frame)
                             : draw_outlines<Blend<false, false>>(params, job, scratch, frame);
    }
    return needs.colours ? draw_outlines<Blend<true, true>>(params, job, scratch, frame)
                         : draw_outlines<Blend<true, false>>(params, job, scratch, frame);
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(draw_tile);
HWY_EXPORT(name_of_target);

const char* instruction_set() {
    return HWY_DYNAMIC_DISPATCH(name_of_target)();
}

void draw_tile(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    HWY_DYNAMIC_DISPATCH(draw_tile)(params, job, scratch, frame);
}

}  // namespace render
#endif
