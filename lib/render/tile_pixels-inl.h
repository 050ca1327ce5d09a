// What becomes of fragments in a block's pixels: the nearest has them, or those that are near each other are
// blended.
//
// A kind of pixel is a type: its planes, one vector of a block after the other; put(), which takes a
// fragment; and shade(), which says what it looks like. (Highway per-target header: included once for each
// instruction set.)
#if defined(RENDER_TILE_PIXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_TILE_PIXELS_INL_H_
#undef RENDER_TILE_PIXELS_INL_H_
#else
#define RENDER_TILE_PIXELS_INL_H_
#endif

#include <hwy/highway.h>

#include "render/shading-inl.h"
#include "render/tile_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// Inverse depth of what nothing was drawn on: farther than infinity, so that the first fragment always starts
// a pixel afresh and no other plane needs clearing.
constexpr float kNothing = -3.0e38f;

// What one splat puts into the lanes of one vector.
struct Fragment {
    M inside;
    V w;      // inverse depth
    V order;  // the same, or of a cover that times kCoverOrder
    V t;      // 1 in the splat's middle, kEdge at its rim
    V push;   // R of depth as a difference of orders
    V gain;   // see gain_of()
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

    HWY_INLINE static V inverse_depth(const float* at) { return hn::Load(F(), at + kDepth * kBlockPixels); }
    HWY_INLINE static hn::Vec<U> shade(const SetupParams&, const float* at) {
        return hn::BitCast(U(), hn::Load(F(), at + kColour * kBlockPixels));
    }
};

// Splats within their push of the nearest so far are blended with weight t times their gain; what is nearer
// by more starts the pixel afresh, what is farther by more is left out.  Depends on the order.  The depth is
// that of the splat of largest weight and not a mean: a point between two sheets is on neither.
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
        const V weight = hn::IfThenElseZero(counts, hn::Mul(f.t, f.gain));
        hn::Store(hn::IfThenElse(counts, hn::Max(f.order, front), front), d, at + kFront * kBlockPixels);
        add(afresh, weight, at + kWeight * kBlockPixels);
        const V largest = hn::IfThenZeroElse(afresh, hn::Load(d, at + kLargest * kBlockPixels));
        const M leads = hn::And(counts, hn::Or(afresh, hn::Gt(weight, largest)));
        hn::Store(hn::Max(largest, weight), d, at + kLargest * kBlockPixels);
        hn::Store(hn::IfThenElse(leads, f.w, hn::Load(d, at + kDepth * kBlockPixels)), d,
                  at + kDepth * kBlockPixels);
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

    HWY_INLINE static V inverse_depth(const float* at) { return hn::Load(F(), at + kDepth * kBlockPixels); }

    HWY_INLINE static hn::Vec<U> shade(const SetupParams& params, const float* at) {
        const F d;
        V nx = hn::Zero(d), ny = hn::Zero(d), nz = hn::Zero(d);
        if constexpr (kNormals) {
            nx = hn::Load(d, at + (kPayload + 0) * kBlockPixels);
            ny = hn::Load(d, at + (kPayload + 1) * kBlockPixels);
            nz = hn::Load(d, at + (kPayload + 2) * kBlockPixels);
            const V squares = hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz));
            // Opposite normals may cancel to nothing; the pixel is then left with ambient light.
            // Divided, and not multiplied by an inverse: so a normal along an axis is one again.
            const V length = hn::Sqrt(hn::Max(squares, hn::Set(d, 1.0e-30f)));
            nx = hn::Div(nx, length), ny = hn::Div(ny, length), nz = hn::Div(nz, length);
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

// A pixel that takes only what is between the view's near and far, and in front of its triangle.  Covers in
// front of it are not behind it as they are behind cores: where triangles and splats of a surface meet, what
// lies farther back would show between them.
template <class Pixel>
struct Limited : Pixel {
    static constexpr int kLimit = Pixel::kPlanes, kPlanes = Pixel::kPlanes + 1;
    static_assert(kPlanes <= kMaxPlanes);

    V least_w, most_w;

    HWY_INLINE explicit Limited(const Surface& surface)
        : Pixel(surface), least_w(hn::Set(F(), surface.least_w)), most_w(hn::Set(F(), surface.most_w)) {}

    HWY_INLINE void put(const Fragment& f, float* HWY_RESTRICT at) const {
        Fragment shown = f;
        const M in_front = hn::Gt(f.w, hn::Load(F(), at + kLimit * kBlockPixels));
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

template <class Pixel>
HWY_INLINE float* block_at(float* state, int bx, int by) {
    return state + size_t(by * kBlocksAcross + bx) * Pixel::kPlanes * kBlockPixels;
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
