#include "render/tile.h"

#include <algorithm>

#include "render/tile_triangles.h"

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/tile.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/tile_resolve-inl.h"
#include "render/tile_splats-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

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
// started afresh stays no number.  With Nearest the same goes for the key, which is below w.  What counts is
// the order, which is w or, of a cover, far less: a hidden cover is below the limit all the more, and a cover
// that is drawn starts no such pixel afresh, so that it stays no number until a core does.
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
    if constexpr (Pixel::kBlends) {
        const bool lacks_triangles = params.options.has_triangles && job.map && !job.map->is_repeated();
        if (lacks_triangles) return draw_pixels<Doubtful<Pixel>, kShape>(params, job, scratch, frame);
    }
    if (params.has_limits() || job.triangles)
        return draw_pixels<Limited<Pixel>, kShape>(params, job, scratch, frame);
    draw_pixels<Pixel, kShape>(params, job, scratch, frame);
}

template <class Pixel>
void draw_ellipsoids(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame) {
    draw_and_shade<Pixel, Shape::ellipsoid>(params, job, scratch, frame);
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
    if (options.kind == SplatKind::circle)
        return draw_and_shade<Nearest, Shape::circle>(params, job, scratch, frame);
    if (options.kind == SplatKind::ellipse) return draw_ellipsoids<Nearest>(params, job, scratch, frame);
    const ShadingNeeds needs = needs_of(options);
    if (!needs.normals) {
        return needs.colours ? draw_ellipsoids<Blend<false, true>>(params, job, scratch, frame)
                             : draw_ellipsoids<Blend<false, false>>(params, job, scratch, frame);
    }
    return needs.colours ? draw_ellipsoids<Blend<true, true>>(params, job, scratch, frame)
                         : draw_ellipsoids<Blend<true, false>>(params, job, scratch, frame);
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
