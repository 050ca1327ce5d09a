// A disc cut into convex cells, to bound how far its points are from convex parts of a surface.  Included
// once for each SIMD target, by sources that use Highway's foreach_target.h.
#if defined(QS_SPLAT_CELLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_CELLS_INL_H
#undef QS_SPLAT_CELLS_INL_H
#else
#define QS_SPLAT_CELLS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Corners of the cells on the unit disc: the centre, and three rings of 16, the outermost drawn round the
// circle.
constexpr int kSectors = 16, kRings = 3;
using Sectors = hn::CappedTag<float, kSectors>;
struct Rings {
    float x[kRings][kSectors], y[kRings][kSectors];
    Rings() {
        const double radius[kRings] = {0.4, 0.72, 1.0001 / std::cos(3.14159265358979 / kSectors)};
        for (int r = 0; r < kRings; ++r)
            for (int k = 0; k < kSectors; ++k) {
                const double phi = 2 * 3.14159265358979 * k / kSectors;
                x[r][k] = float(radius[r] * std::cos(phi)), y[r][k] = float(radius[r] * std::sin(phi));
            }
    }
};

// A cell cut into 4 x 4, by its corners and all between them.
constexpr int kCuts = 4, kGrid = (kCuts + 1) * (kCuts + 1), kGridRoom = kGrid + 16;
struct CellGrid {
    float x[kGridRoom], y[kGridRoom];
    float x_middle, y_middle, reach;  // no point of the cell is further from its middle

    CellGrid(const Rings& rings, float radius, int ring, int sector) {
        const auto corner = [&](int r, int k) {
            return r < 0 ? glm::vec2(0)
                         : radius * glm::vec2(rings.x[r][k % kSectors], rings.y[r][k % kSectors]);
        };
        const glm::vec2 a = corner(ring - 1, sector), b = corner(ring - 1, sector + 1),
                        c = corner(ring, sector), e = corner(ring, sector + 1);
        for (int k = 0; k < kGridRoom; ++k) {
            const int at = std::min(k, kGrid - 1);
            const float s = float(at % (kCuts + 1)) / kCuts, t = float(at / (kCuts + 1)) / kCuts;
            const glm::vec2 p = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * e);
            x[k] = p.x, y[k] = p.y;
        }
        const glm::vec2 middle = 0.25f * (a + b + c + e);
        x_middle = middle.x, y_middle = middle.y, reach = 0;
        for (const glm::vec2& p : {a, b, c, e}) reach = std::max(reach, glm::length(p - middle));
    }
};

// Bound on the distance of the disc's points from the nearest of some convex parts, each with its own error:
// cell by cell the part whose distance, at the cell's corners, is least.  square(part, x, y) is that of the
// distance from (x, y, 0).
template <class Square, class Error>
class Cells {
  public:
    Cells(float radius, size_t count, const Square& square, const Error& error)
        : radius_(radius), count_(count), square_(square), error_(error) {
        for (auto& ring : bound_) std::fill(ring, ring + kSectors, std::numeric_limits<float>::infinity());
        const Sectors d;
        const hn::RebindToSigned<Sectors> di;
        const auto to = hn::Add(hn::Iota(di, 0), hn::Set(di, 1)), lanes = hn::Set(di, int32_t(hn::Lanes(d)));
        last_ = hn::RebindMask(d, hn::Eq(to, lanes));
        up_ = hn::IndicesFromVec(d, hn::IfThenZeroElse(hn::Eq(to, lanes), to));
    }

    // Bounds up to `enough` are not made smaller.
    HWY_INLINE float bound(float enough) {
        for (size_t part = 0; part < count_ && (part % 8 != 0 || worst() > enough); ++part) take(part);
        return worst();
    }

    // The same, with the worst cells cut finer.
    float fine_bound(float enough) {
        bound(enough);
        bool is_fine[kRings * kSectors] = {};
        float* const cells = bound_[0];
        for (;;) {
            float* const at = std::max_element(cells, cells + kRings * kSectors);
            const auto cell = int(at - cells);
            if (is_fine[cell] || !std::isfinite(*at) || *at <= enough) return *at;
            is_fine[cell] = true;
            const float known = *at;
            *at = cut(cell, known);
            if (*at > 0.98f * known) return known;
        }
    }

  private:
    using Sector = hn::Vec<Sectors>;
    static constexpr size_t kVectors = kSectors / hn::MaxLanes(Sectors());

    static const Rings& rings() {
        static const Rings rings;
        return rings;
    }

    // Without branches: skipping the rings where a part is not nearer than others takes half as long again.
    void take(size_t part) {
        const Sectors d;
        const Sector scale = hn::Set(d, radius_), error = hn::Set(d, error_(part));
        const Sector middle = square_(part, hn::Zero(d), hn::Zero(d));
        Sector inner[kVectors], outer[kVectors], next[kVectors];
        for (Sector& v : inner) v = middle;
        for (int r = 0; r < kRings; ++r) {
            for (size_t v = 0; v < kVectors; ++v) {
                const size_t k = v * hn::Lanes(d);
                outer[v] = square_(part, hn::Mul(scale, hn::LoadU(d, rings().x[r] + k)),
                                   hn::Mul(scale, hn::LoadU(d, rings().y[r] + k)));
                next[v] = hn::TableLookupLanes(outer[v], up_);
            }
            for (size_t v = 0; v < kVectors; ++v) {
                const Sector most =
                    hn::Max(outer[v], hn::IfThenElse(last_, next[(v + 1) % kVectors], next[v]));
                float* const bound = bound_[r] + v * hn::Lanes(d);
                hn::StoreU(hn::Min(hn::LoadU(d, bound), hn::Add(error, hn::Sqrt(hn::Max(inner[v], most)))), d,
                           bound);
                inner[v] = most;
            }
        }
    }

    float worst() const {
        const Sectors d;
        auto worst = hn::Zero(d);
        for (const auto& ring : bound_)
            for (size_t k = 0; k < kSectors; k += hn::Lanes(d))
                worst = hn::Max(worst, hn::LoadU(d, ring + k));
        return hn::GetLane(hn::MaxOfLanes(d, worst));
    }

    // The bound of one cell, by its 16 parts.
    float cut(int cell, float known) const {
        const Sectors d;
        const CellGrid grid(rings(), radius_, cell / kSectors, cell % kSectors);
        float bound[kCuts * kCuts];
        std::fill(bound, bound + kCuts * kCuts, known);
        for (size_t part = 0; part < count_; ++part) {
            const float middle =
                std::sqrt(hn::GetLane(square_(part, hn::Set(d, grid.x_middle), hn::Set(d, grid.y_middle))));
            if (middle - grid.reach + error_(part) >= known) continue;
            float at[kGridRoom];
            for (int k = 0; k < kGrid; k += int(hn::Lanes(d)))
                hn::StoreU(hn::Sqrt(square_(part, hn::LoadU(d, grid.x + k), hn::LoadU(d, grid.y + k))), d,
                           at + k);
            for (int k = 0; k < kCuts * kCuts; ++k) {
                const float* corner = at + k / kCuts * (kCuts + 1) + k % kCuts;
                const float most =
                    std::max(std::max(corner[0], corner[1]), std::max(corner[kCuts + 1], corner[kCuts + 2]));
                bound[k] = std::min(bound[k], error_(part) + most);
            }
        }
        return *std::max_element(bound, bound + kCuts * kCuts);
    }

    const float radius_;
    const size_t count_;
    const Square& square_;
    const Error& error_;
    float bound_[kRings][kSectors];
    // From corner to corner round a ring: through memory it takes half as long again.
    decltype(hn::SetTableIndices(Sectors(), static_cast<const int32_t*>(nullptr))) up_;
    hn::Mask<Sectors> last_;
};

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
