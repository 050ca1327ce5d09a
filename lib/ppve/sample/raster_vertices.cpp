#include "ppve/sample/raster_vertices.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ppve/sample/raster_vertices.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ppve::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most eight, by which vertices are padded.
using D = hn::CappedTag<double, ClusterView::kVertexPadding>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using VU = hn::Vec<DU>;

// The low 16 bits of a whole number between -2^51 and 2^51, as two's complement.
HWY_INLINE VU low_bits(V whole) {
    const D d;
    const DU du;
    return hn::And(hn::BitCast(du, hn::Add(whole, hn::Set(d, 0x1.8p52))), hn::Set(du, 0xffff));
}

// The first pixel of `count` with a centre at or after `place`, and ~ the last with one at or before it.
struct Ends {
    VU first, not_last;
};
HWY_INLINE Ends ends_of(V place, double slack, int count) {
    const D d;
    const V middle = hn::Sub(place, hn::Set(d, 0.5));
    const V first = hn::Ceil(hn::Sub(middle, hn::Set(d, slack))),
            last = hn::Floor(hn::Add(middle, hn::Set(d, slack)));
    const V zero = hn::Zero(d), one = hn::Set(d, 1);
    const V first_in = hn::Min(hn::Max(first, zero), hn::Set(d, count));
    const V last_in = hn::Min(hn::Max(last, hn::Neg(one)), hn::Set(d, count - 1));
    return {low_bits(first_in), low_bits(hn::Sub(hn::Neg(last_in), one))};
}

// In the order of glm::dot(), so that rays are those of render::MeshRaster to the bit.
HWY_INLINE V along(const double* axis, V x, V y, V z) {
    const D d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, axis[0]), x), hn::Mul(hn::Set(d, axis[1]), y)),
                   hn::Mul(hn::Set(d, axis[2]), z));
}

HWY_INLINE V from_eye(const RasterFrame& f, int axis, const float* positions) {
    const D d;
    const V position = hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, D>(), positions));
    return hn::Sub(hn::Add(hn::Set(d, f.offset[axis]), position), hn::Set(d, f.eye[axis]));
}

void PlaceVertices(const RasterFrame& f, const ClusterView& c, RasterVertices& out) {
    const D d;
    const DU du;
    const V one = hn::Set(d, 1), scale = hn::Set(d, f.scale), focal = hn::Set(d, f.focal_px);
    const V farthest = hn::Set(d, kFarthestPlace);
    for (size_t v = 0; v < c.vertices; v += hn::Lanes(d)) {
        const V px = from_eye(f, 0, c.x + v), py = from_eye(f, 1, c.y + v), pz = from_eye(f, 2, c.z + v);
        const V x = hn::Mul(focal, hn::Mul(along(f.axes[0], px, py, pz), scale));
        const V y = hn::Mul(focal, hn::Mul(along(f.axes[1], px, py, pz), scale));
        const V z = hn::Mul(along(f.axes[2], px, py, pz), scale);
        const V inverse = f.perspective ? hn::Div(one, z) : one;
        const V at_x = hn::Mul(x, inverse), at_y = hn::Mul(y, inverse);
        const auto has_place = hn::And(hn::Le(hn::Abs(at_x), farthest), hn::Le(hn::Abs(at_y), farthest));
        const auto before_eye = hn::Lt(hn::Zero(d), f.perspective ? z : one);
        const Ends ex = ends_of(hn::Sub(at_x, hn::Set(d, f.corner_x)), f.slack, f.width);
        const Ends ey = ends_of(hn::Sub(at_y, hn::Set(d, f.corner_y)), f.slack, f.height);
        const VU span = hn::Or(hn::Or(ex.first, hn::ShiftLeft<16>(ey.first)),
                               hn::Or(hn::ShiftLeft<32>(ex.not_last), hn::ShiftLeft<48>(ey.not_last)));
        const auto good = hn::RebindMask(du, hn::And(has_place, before_eye));
        hn::StoreU(at_x, d, out.x + v), hn::StoreU(at_y, d, out.y + v);
        hn::StoreU(f.perspective ? inverse : z, d, out.w + v);
        hn::StoreU(hn::IfThenElse(good, span, hn::Set(du, uint64_t(0x80008000))), du, out.span + v);
    }
}

}  // namespace ppve::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ppve {

HWY_EXPORT(PlaceVertices);

void place_vertices(const RasterFrame& frame, const ClusterView& cluster, RasterVertices& out) {
    HWY_DYNAMIC_DISPATCH(PlaceVertices)(frame, cluster, out);
}

namespace {

// The four numbers of a PackedSpan; one register, on any processor.
using Span16 = int16_t __attribute__((vector_size(8)));

Span16 least(Span16 a, Span16 b) {
    return a < b ? a : b;
}

}  // namespace

size_t find_drawable(const ClusterView& cluster, const RasterVertices& vertices, uint16_t* out) {
    size_t found = 0;
    for (uint32_t t = 0; t < cluster.triangles; ++t) {
        const uint16_t* corners = cluster.corners + 3 * size_t(t);
        const auto span = [&](int k) { return std::bit_cast<Span16>(vertices.span[corners[k]]); };
        const uint64_t all = std::bit_cast<uint64_t>(least(least(span(0), span(1)), span(2)));
        const int first_x = int16_t(all), first_y = int16_t(all >> 16);
        const int not_last_x = int16_t(all >> 32), not_last_y = int16_t(all >> 48);
        out[found] = uint16_t(t);
        // last - first is -1 - (first + ~last); no branch, which could not be foreseen.
        found += ((first_x + not_last_x) & (first_y + not_last_y)) < 0;
    }
    return found;
}

}  // namespace ppve
#endif
