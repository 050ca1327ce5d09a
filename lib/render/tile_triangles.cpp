#include "render/tile_triangles.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>

#include "render/exact_triangle.h"
#include "render/tile.h"

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/tile_triangles.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/octahedral-inl.h"
#include "render/shading-inl.h"
#include "render/tile_blocks-inl.h"

#ifndef RENDER_TILE_TRIANGLES_ONCE
#define RENDER_TILE_TRIANGLES_ONCE
namespace render {

// Edge functions in single precision are off by less than this times the sum of their terms' magnitudes:
// three roundings of what they are made of and three of sums, and room for as many.
inline constexpr double kFloatRounding = 12 * 0x1p-24;

// Edge functions are in corners' weights; with more doubt than this the other planes would be in doubt, too.
inline constexpr double kMostDoubt = 0.01;

// What is the same for all triangles of a tile.
struct TriangleTile {
    const SetupParams& params;
    Raster raster;
    int x0, y0;  // first pixel, of the picture
    bool has_normals, has_colours;
    float floor_w;  // inverse depth of what nothing is drawn on yet
    TriangleScratch& scratch;

    TriangleTile(const SetupParams& of, int left, int top, TriangleScratch& with)
        : params(of), raster(of.view, 1), x0(left), y0(top), scratch(with) {
        const Shade shade = of.options.look.shade;
        has_normals = shade != Shade::flat;
        has_colours = of.options.has_colour && shade != Shade::normal && shade != Shade::level;
        // Just beyond `far`, which itself is still drawn.
        floor_w = std::max(std::nextafter(of.least_w, -FLT_MAX), kNoTriangle);
    }

    void rays_of(const PackedTriangle& t, Ray (&rays)[3]) const {
        for (size_t k = 0; k < 3; ++k)
            rays[k] = ray_of(params.view, t.corners[k][0], t.corners[k][1], t.corners[k][2]);
    }
    // Of the tile's pixel (x, y).
    double centre_x(int x) const { return raster.centre_x(x0 + x - raster.left); }
    double centre_y(int y) const { return raster.centre_y(y0 + y - raster.top); }
};

inline size_t pixel_index(int x, int y) {
    const int block = y / kBlockSize * kBlocksAcross + x / kBlockSize;
    return size_t(block * kBlockPixels + y % kBlockSize * kBlockSize + x % kBlockSize);
}

// Which of the pixels lane, lane + 1, ... of a block, bit by bit, a triangle covers, of those that are asked
// for.
inline uint32_t covered_exactly(const TriangleTile& tile, const PackedTriangle& triangle, int x, int y,
                                size_t lane, uint32_t asked) {
    Ray rays[3];
    tile.rays_of(triangle, rays);
    TriangleSetup setup;
    if (!setup.set(tile.raster, rays[0], rays[1], rays[2])) return 0;
    uint32_t covered = 0;
    for (uint32_t i = 0; asked >> i != 0; ++i) {
        if (!(asked >> i & 1)) continue;
        const int at = static_cast<int>(lane + i);
        TriangleSetup::Meeting met;
        if (setup.meets(tile.centre_x(x + at % kBlockSize), tile.centre_y(y + at / kBlockSize), met))
            covered |= 1u << i;
    }
    return covered;
}

}  // namespace render
#endif

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

using D = hn::ScalableTag<double>;
using W = hn::Vec<D>;
using DF = hn::Rebind<float, D>;

struct Corner {
    W x, y, z;
};

HWY_INLINE Corner cross(const Corner& a, const Corner& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

HWY_INLINE W load_wide(const float* at) {
    return hn::PromoteTo(D(), hn::Load(DF(), at));
}
HWY_INLINE void store_narrow(W value, float* at) {
    hn::Store(hn::DemoteTo(DF(), value), DF(), at);
}

constexpr size_t kAhead = 16;  // triangles that are asked for before they are read

// What becomes of a triangle, in TriangleScratch::doubt: else how much of that there is.
constexpr float kDropped = -1, kExact = -2;

// The planes of the edges and of inverse depth, of `count` triangles.
HWY_INLINE void set_up_edges(const TriangleTile& tile, size_t count) {
    const D d;
    TriangleScratch& s = tile.scratch;
    const geom::View& view = tile.params.view;
    const W zero = hn::Zero(d), focal = hn::Set(d, view.focal_px);
    const glm::dvec2 principal = view.principal();
    // Of the picture and not of the raster, so that parts of a picture are as the whole.
    const double picture_reach =
        std::max(std::max(std::abs(principal.x), std::abs(view.picture_width() - principal.x)),
                 std::max(std::abs(principal.y), std::abs(view.picture_height() - principal.y)));
    const W reach = hn::Set(d, picture_reach);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        Corner corners[3];
        W magnitudes[3];
        for (size_t k = 0; k < 3; ++k) {
            hn::Vec<DF> x, y, z, code;
            hn::LoadInterleaved4(DF(), s.corners[k] + 4 * i, x, y, z, code);
            corners[k] = {hn::Mul(hn::PromoteTo(d, x), focal), hn::Mul(hn::PromoteTo(d, y), focal),
                          hn::PromoteTo(d, z)};
            magnitudes[k] = hn::Max(hn::Max(hn::Abs(corners[k].x), hn::Abs(corners[k].y)),
                                    hn::Mul(reach, hn::Abs(corners[k].z)));
        }
        const Corner normals[3] = {cross(corners[1], corners[2]), cross(corners[2], corners[0]),
                                   cross(corners[0], corners[1])};
        const W nearest = hn::Min(hn::Min(corners[0].z, corners[1].z), corners[2].z);
        const W farthest = hn::Max(hn::Max(corners[0].z, corners[1].z), corners[2].z);
        const W det =
            hn::Add(hn::Mul(normals[0].x, corners[0].x),
                    hn::Add(hn::Mul(normals[0].y, corners[0].y), hn::Mul(normals[0].z, corners[0].z)));
        const W rounding = hn::Set(d, kRounding);
        const W det_doubt = hn::Mul(hn::Mul(rounding, hn::Mul(magnitudes[0], magnitudes[1])),
                                    hn::Mul(magnitudes[2], hn::Set(d, 1 / picture_reach)));
        // At the depth of the farthest corner the edge functions are the weights.
        const W scale = hn::Div(farthest, det), inverse_farthest = hn::Div(hn::Set(d, 1.0), farthest);
        const W first_x = hn::Add(load_wide(s.first_x + i), hn::Set(d, 0.5 - principal.x));
        const W first_y = hn::Add(load_wide(s.first_y + i), hn::Set(d, 0.5 - principal.y));
        const W width = load_wide(s.width + i), height = load_wide(s.height + i);
        W doubt = zero, least = hn::Set(d, DBL_MAX), w_at = zero, w_dx = zero, w_dy = zero;
        for (size_t k = 0; k < 3; ++k) {
            const Corner& n = normals[k];
            const W at = hn::Mul(hn::Add(hn::Mul(n.x, first_x), hn::Add(hn::Mul(n.y, first_y), n.z)), scale);
            const W dx = hn::Mul(n.x, scale), dy = hn::Mul(n.y, scale);
            const W in_double = hn::Mul(hn::Mul(rounding, hn::Abs(scale)),
                                        hn::Mul(magnitudes[(k + 1) % 3], magnitudes[(k + 2) % 3]));
            const W terms =
                hn::Add(hn::Abs(at), hn::Add(hn::Mul(hn::Abs(dx), width), hn::Mul(hn::Abs(dy), height)));
            doubt = hn::Max(doubt, hn::Add(in_double, hn::Mul(terms, hn::Set(d, kFloatRounding))));
            const W most =
                hn::Add(at, hn::Add(hn::Mul(hn::Max(dx, zero), width), hn::Mul(hn::Max(dy, zero), height)));
            least = hn::Min(least, most);
            w_at = hn::Add(w_at, at), w_dx = hn::Add(w_dx, dx), w_dy = hn::Add(w_dy, dy);
            store_narrow(at, s.planes[k][0] + i);
            store_narrow(dx, s.planes[k][1] + i);
            store_narrow(dy, s.planes[k][2] + i);
        }
        store_narrow(hn::Mul(w_at, inverse_farthest), s.planes[3][0] + i);
        store_narrow(hn::Mul(w_dx, inverse_farthest), s.planes[3][1] + i);
        store_narrow(hn::Mul(w_dy, inverse_farthest), s.planes[3][2] + i);
        store_narrow(inverse_farthest, s.least_w + i);
        store_narrow(hn::Div(hn::Set(d, 1.0), nearest), s.most_w + i);
        // False for what is no number.
        const auto is_finite = hn::Lt(hn::Abs(scale), hn::Set(d, DBL_MAX));
        const auto is_solid = hn::And(hn::Gt(hn::Abs(det), det_doubt), is_finite);
        const auto is_clear =
            hn::And(hn::And(hn::Gt(nearest, zero), is_solid), hn::Lt(doubt, hn::Set(d, kMostDoubt)));
        const auto is_outside = hn::And(is_clear, hn::Lt(least, hn::Neg(doubt)));
        // Not so little that it vanishes in single precision.
        const W noted = hn::Max(doubt, hn::Set(d, 1.0e-30));
        store_narrow(hn::IfThenElse(is_outside, hn::Set(d, kDropped),
                                    hn::IfThenElse(is_clear, noted, hn::Set(d, kExact))),
                     s.doubt + i);
    }
}

// Those of the normals, from the edges'; and all of them into the triangles' records.
template <bool kNormals>
HWY_INLINE void write_records(const TriangleTile& tile, size_t count) {
    const hn::ScalableTag<float> d;
    const hn::RebindToUnsigned<decltype(d)> du;
    using Vector = hn::Vec<decltype(d)>;
    TriangleScratch& s = tile.scratch;
    // Of at, dx and dy: four planes of a triangle, the next one's; and so on.
    alignas(64) float edges[3][4 * hn::MaxLanes(d)], weighted[3][4 * hn::MaxLanes(d)];
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        Normals<Vector> normals[3];
        for (size_t k = 0; kNormals && k < 3; ++k) {
            Vector x, y, z, code;
            hn::LoadInterleaved4(d, s.corners[k] + 4 * i, x, y, z, code);
            normals[k] = octahedral_normals(d, hn::BitCast(du, code));
        }
        for (size_t part = 0; part < 3; ++part) {
            const auto plane = [&](size_t k) HWY_ATTR { return hn::Load(d, s.planes[k][part] + i); };
            const Vector a = plane(0), b = plane(1), c = plane(2);
            hn::StoreInterleaved4(a, b, c, plane(3), d, edges[part]);
            if constexpr (kNormals) {
                const auto mix = [&](Vector of_a, Vector of_b, Vector of_c) HWY_ATTR {
                    return hn::Add(hn::Add(hn::Mul(a, of_a), hn::Mul(b, of_b)), hn::Mul(c, of_c));
                };
                hn::StoreInterleaved4(mix(normals[0].x, normals[1].x, normals[2].x),
                                      mix(normals[0].y, normals[1].y, normals[2].y),
                                      mix(normals[0].z, normals[1].z, normals[2].z), hn::Zero(d), d,
                                      weighted[part]);
            }
        }
        const size_t end = std::min(count - i, hn::Lanes(d));
        for (size_t lane = 0; lane < end; ++lane) {
            TriangleRecord& record = s.records[i + lane];
            float* const parts[3] = {record.at, record.dx, record.dy};
            for (size_t part = 0; part < 3; ++part) {
                std::memcpy(parts[part], edges[part] + 4 * lane, 4 * sizeof(float));
                if constexpr (kNormals)
                    std::memcpy(parts[part] + TriangleRecord::kNormal, weighted[part] + 4 * lane,
                                4 * sizeof(float));
            }
            record.doubt = s.doubt[i + lane];
            record.least_w = s.least_w[i + lane], record.most_w = s.most_w[i + lane];
        }
    }
}

// Decides what single precision leaves in doubt.
HWY_NOINLINE M settle(const TriangleTile& tile, const TriangleRecord& r, int x, int y, size_t lane, M inside,
                      M doubtful) {
    const F d;
    uint8_t asked[8] = {}, covered[8] = {};
    hn::StoreMaskBits(d, doubtful, asked);
    uint32_t bits;
    std::memcpy(&bits, asked, sizeof(bits));
    bits = covered_exactly(tile, *r.triangle, x, y, lane, bits);
    std::memcpy(covered, &bits, sizeof(bits));
    return hn::Or(inside, hn::LoadMaskBits(d, covered));
}

template <bool kNormals, bool kColours>
HWY_INLINE void draw_record(const TriangleTile& tile, const TriangleRecord& r) {
    using R = TriangleRecord;
    const F d;
    const hn::CappedTag<float, R::kPlanes> planes;
    TriangleScratch& s = tile.scratch;
    const V doubt = hn::Set(d, r.doubt), certain = hn::Neg(doubt);
    const V least_w = hn::Set(d, r.least_w), most_w = hn::Set(d, r.most_w);
    const V nearest_w = hn::Set(d, tile.params.most_w);
    const V colour = hn::BitCast(d, hn::Set(U(), r.colour));
    for (size_t lane = 0; lane < kBlockPixels; lane += hn::Lanes(d)) {
        const V lane_x = hn::Load(d, kLaneX + lane), lane_y = hn::Load(d, kLaneY + lane);
        const auto slope = [&](size_t plane) HWY_ATTR {
            return hn::Add(hn::Mul(hn::Set(d, r.dx[plane]), lane_x),
                           hn::Mul(hn::Set(d, r.dy[plane]), lane_y));
        };
        const V edge_a = slope(R::kEdges), edge_b = slope(R::kEdges + 1), edge_c = slope(R::kEdges + 2);
        const V lane_w = slope(R::kW);
        const V normal_x = slope(R::kNormal), normal_y = slope(R::kNormal + 1),
                normal_z = slope(R::kNormal + 2);
        // Blocks that turn out to be empty are not skipped: the test, being mispredicted, cost 20 %.
        for (int by = r.block_y0; by <= r.block_y1; ++by) {
            const auto dy = hn::Set(planes, static_cast<float>((by - r.block_y0) * kBlockSize));
            size_t at = size_t(by * kBlocksAcross + r.block_x0) * kBlockPixels + lane;
            for (int bx = r.block_x0; bx <= r.block_x1; ++bx, at += kBlockPixels) {
                const auto dx = hn::Set(planes, static_cast<float>((bx - r.block_x0) * kBlockSize));
                alignas(32) float here[R::kPlanes];
                for (size_t p = 0; p < R::kPlanes; p += hn::Lanes(planes)) {
                    const auto of_x = hn::Mul(hn::Load(planes, r.dx + p), dx);
                    const auto of_y = hn::Mul(hn::Load(planes, r.dy + p), dy);
                    hn::Store(hn::Add(hn::Load(planes, r.at + p), hn::Add(of_x, of_y)), planes, here + p);
                }
                const auto plane = [&](size_t p, V of_lane)
                                       HWY_ATTR { return hn::Add(of_lane, hn::Set(d, here[p])); };
                const V least = hn::Min(hn::Min(plane(R::kEdges, edge_a), plane(R::kEdges + 1, edge_b)),
                                        plane(R::kEdges + 2, edge_c));
                M inside = hn::Gt(least, doubt);
                const M doubtful = hn::AndNot(inside, hn::Ge(least, certain));
                if (HWY_UNLIKELY(!hn::AllFalse(d, doubtful)))
                    inside = settle(tile, r, bx * kBlockSize, by * kBlockSize, lane, inside, doubtful);
                const V w = hn::Clamp(plane(R::kW, lane_w), least_w, most_w);
                const M nearer = hn::Gt(w, hn::Load(d, s.shown.w + at));
                const M wins = hn::And(inside, hn::And(nearer, hn::Le(w, nearest_w)));
                store_where(wins, w, s.shown.w + at);
                if constexpr (kNormals) {
                    store_where(wins, plane(R::kNormal, normal_x), s.normals[0] + at);
                    store_where(wins, plane(R::kNormal + 1, normal_y), s.normals[1] + at);
                    store_where(wins, plane(R::kNormal + 2, normal_z), s.normals[2] + at);
                }
                if constexpr (kColours) {
                    float* const colours = reinterpret_cast<float*>(s.shown.colour);
                    store_where(wins, colour, colours + at);
                }
            }
        }
    }
}

// The same in double precision.
void draw_exactly(const TriangleTile& tile, const TriangleRecord& r) {
    const PackedTriangle& triangle = *r.triangle;
    TriangleScratch& s = tile.scratch;
    Ray rays[3];
    tile.rays_of(triangle, rays);
    TriangleSetup setup;
    if (!setup.set(tile.raster, rays[0], rays[1], rays[2])) return;
    const hn::CappedTag<float, 1> d1;
    glm::vec3 normals[3];
    for (size_t k = 0; k < 3; ++k) {
        uint32_t code;
        std::memcpy(&code, &triangle.corners[k][3], sizeof(code));
        const auto n = octahedral_normals(d1, hn::Set(hn::RebindToUnsigned<decltype(d1)>(), code));
        normals[k] = {hn::GetLane(n.x), hn::GetLane(n.y), hn::GetLane(n.z)};
    }
    const int left = tile.x0 - tile.raster.left, top = tile.y0 - tile.raster.top;
    for (int by = r.block_y0; by <= r.block_y1; ++by) {
        for (int bx = r.block_x0; bx <= r.block_x1; ++bx) {
            const int x = bx * kBlockSize, y = by * kBlockSize;
            if (!setup.may_touch(tile.raster,
                                 {left + x, top + y, left + x + kBlockSize - 1, top + y + kBlockSize - 1}))
                continue;
            for (int i = 0; i < kBlockPixels; ++i) {
                const int px = x + i % kBlockSize, py = y + i / kBlockSize;
                TriangleSetup::Meeting met;
                if (!setup.meets(tile.centre_x(px), tile.centre_y(py), met)) continue;
                const float w = static_cast<float>(std::min(1 / met.z, double(FLT_MAX)));
                const size_t at = pixel_index(px, py);
                if (!(w > s.shown.w[at] && w <= tile.params.most_w)) continue;
                const float b = static_cast<float>(met.weight_b), c = static_cast<float>(met.weight_c);
                const glm::vec3 normal = (1 - b - c) * normals[0] + b * normals[1] + c * normals[2];
                s.shown.w[at] = w;
                s.shown.colour[at] = triangle.colour;
                for (int k = 0; k < 3; ++k) s.normals[k][at] = normal[k];
            }
        }
    }
}

// Where in the tile some triangles of scratch.triangles may lie, for the set-up.
HWY_INLINE void place(const TriangleTile& tile, size_t begin, size_t count) {
    TriangleScratch& s = tile.scratch;
    const PackedTriangle* const* const triangles = s.triangles.data() + begin;
    for (size_t i = 0; i < count; ++i) {
        hwy::Prefetch(triangles[std::min(i + kAhead, s.triangles.size() - 1 - begin)]);
        const PackedTriangle& t = *triangles[i];
        TriangleRecord& r = s.records[i];
        r.triangle = &t;
        r.colour = t.colour;
        for (size_t k = 0; k < 3; ++k) std::memcpy(s.corners[k] + 4 * i, t.corners[k], sizeof(t.corners[k]));
        r.block_x0 = uint8_t(std::max(t.x0 - tile.x0, 0) / kBlockSize);
        r.block_y0 = uint8_t(std::max(t.y0 - tile.y0, 0) / kBlockSize);
        r.block_x1 = uint8_t(std::min(t.x1 - tile.x0, kTileWidth - 1) / kBlockSize);
        r.block_y1 = uint8_t(std::min(t.y1 - tile.y0, kTileHeight - 1) / kBlockSize);
        s.first_x[i] = static_cast<float>(tile.x0 + r.block_x0 * kBlockSize);
        s.first_y[i] = static_cast<float>(tile.y0 + r.block_y0 * kBlockSize);
        s.width[i] = static_cast<float>((r.block_x1 - r.block_x0 + 1) * kBlockSize - 1);
        s.height[i] = static_cast<float>((r.block_y1 - r.block_y0 + 1) * kBlockSize - 1);
    }
}

template <bool kNormals, bool kColours>
void draw_all(const TriangleTile& tile) {
    TriangleScratch& s = tile.scratch;
    for (size_t begin = 0; begin < s.triangles.size(); begin += TriangleScratch::kGroup) {
        const size_t count = std::min(s.triangles.size() - begin, TriangleScratch::kGroup);
        place(tile, begin, count);
        set_up_edges(tile, count);
        write_records<kNormals>(tile, count);
        for (size_t i = 0; i < count; ++i) {
            const TriangleRecord& r = s.records[i];
            if (r.doubt == kDropped) continue;
            r.doubt == kExact ? draw_exactly(tile, r) : draw_record<kNormals, kColours>(tile, r);
        }
    }
}

HWY_INLINE void shade(const TriangleTile& tile) {
    const F d;
    const Look& look = tile.params.options.look;
    TriangleScratch& s = tile.scratch;
    const V zero = hn::Zero(d), floor_w = hn::Set(d, tile.floor_w), grey = hn::Set(d, kGreyMaterial);
    const glm::vec3 finest(level_colour(0));
    Rgb<V> material{grey, grey, grey};
    if (look.shade == Shade::level)
        material = {hn::Set(d, finest.x), hn::Set(d, finest.y), hn::Set(d, finest.z)};
    for (size_t at = 0; at < kTilePixels; at += hn::Lanes(d)) {
        const V w = hn::Load(d, s.shown.w + at);
        hn::Store(hn::IfThenElse(hn::Gt(w, floor_w), w, hn::Set(d, kNoTriangle)), d, s.shown.w + at);
        if (tile.has_colours) material = unpack_rgb(d, hn::Load(U(), s.shown.colour + at));
        V nx = zero, ny = zero, nz = zero;
        if (tile.has_normals) {
            nx = hn::Load(d, s.normals[0] + at), ny = hn::Load(d, s.normals[1] + at),
            nz = hn::Load(d, s.normals[2] + at);
            const V squares = hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz));
            // Opposite normals may cancel to nothing; the pixel is then left with ambient light.
            const V inverse = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(hn::Max(squares, hn::Set(d, 1.0e-30f))));
            nx = hn::Mul(nx, inverse), ny = hn::Mul(ny, inverse), nz = hn::Mul(nz, inverse);
        }
        hn::Store(shade_points(d, look.shade, tile.params.light, nx, ny, nz, material), U(),
                  s.shown.colour + at);
    }
}

void draw_triangles(const SetupParams& params, int x0, int y0, std::span<const TriangleRun> runs,
                    TriangleScratch& scratch) {
    const TriangleTile tile(params, x0, y0, scratch);
    std::fill_n(scratch.shown.w, kTilePixels, tile.floor_w);
    scratch.triangles.clear();
    for (const TriangleRun& run : runs)
        scratch.triangles.insert(scratch.triangles.end(), run.triangles, run.triangles + run.count);
    for (size_t i = 0; i < std::min(kAhead, scratch.triangles.size()); ++i)
        hwy::Prefetch(scratch.triangles[i]);
    if (tile.has_normals)
        tile.has_colours ? draw_all<true, true>(tile) : draw_all<true, false>(tile);
    else
        tile.has_colours ? draw_all<false, true>(tile) : draw_all<false, false>(tile);
    shade(tile);
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(draw_triangles);

void draw_triangles(const SetupParams& params, int x0, int y0, std::span<const TriangleRun> runs,
                    TriangleScratch& scratch) {
    HWY_DYNAMIC_DISPATCH(draw_triangles)(params, x0, y0, runs, scratch);
}

}  // namespace render
#endif
