// Sampling splats at the pixels of a tile.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_TILE_SPLATS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_TILE_SPLATS_INL_H_
#undef RENDER_TILE_SPLATS_INL_H_
#else
#define RENDER_TILE_SPLATS_INL_H_
#endif

#include <hwy/highway.h>
#include <algorithm>

#include "render/tile_pixels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// What a splat covers: of an ellipsoid the core counts as nearer than the cover of any splat, the rest of the
// ellipsoid, wherever they are.
enum class Shape { square, circle, ellipsoid };

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
    const V push = hn::Set(d, r.push), cover_order = hn::Set(d, kCoverOrder);
    Fragment f;
    f.push = push, f.gain = hn::Set(d, gain_of(r));
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
                if constexpr (kShape == Shape::ellipsoid) {
                    const V s = hn::Add(hn::Mul(core_a, a), hn::Mul(core_b, b));
                    const M is_core = hn::Ge(hn::Sub(f.t, hn::Mul(s, s)), hn::Set(d, kCoreEdge));
                    f.order = hn::IfThenElse(is_core, f.w, hn::Mul(f.w, cover_order));
                    f.push = hn::IfThenElse(is_core, push, hn::Mul(push, cover_order));
                }
                pixel.put(f, at);
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
    // Of least weight, and pushed back by all of R: gives way to whole splats.
    f.t = hn::Set(d, kEdge), f.gain = one;
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

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
