#include "splat/cut/triangle_view.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cut/triangle_view.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/vector3-inl.h"

#ifndef QS_SPLAT_TRIANGLE_VIEW_ONCE
#define QS_SPLAT_TRIANGLE_VIEW_ONCE
namespace splat {

// The arrays of a run's corners, each with room for a vector more.
struct CornerArrays {
    size_t count;
    const int32_t* lattice[3];
    const uint32_t* codes;  // null: no normals
    float *at[3], *normal[3];
};

}  // namespace splat
#endif

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using F = hn::Rebind<float, D>;
using V = hn::Vec<F>;
static_assert(hn::MaxLanes(D()) <= TriangleRun::kRoom);

// decode_corner_normal(), a lane a corner.
HWY_INLINE Vector3<V> DecodeNormals(hn::Vec<hn::Rebind<uint32_t, F>> code) {
    const F f;
    const hn::Rebind<uint32_t, F> u;
    const hn::Rebind<int32_t, F> i;
    const auto middle = hn::Set(f, float((kCornerNormalSteps - 1) / 2)), one = hn::Set(f, 1.0f);
    const auto steps = [&](auto bits) HWY_ATTR {
        const auto step = hn::ConvertTo(f, hn::BitCast(i, hn::And(bits, hn::Set(u, 4095u))));
        return hn::Div(hn::Sub(step, middle), middle);
    };
    const V x = steps(code), y = steps(hn::ShiftRight<12>(code));
    const V ax = hn::Abs(x), ay = hn::Abs(y);
    const V z = hn::Sub(hn::Sub(one, ax), ay);
    const auto below = hn::Lt(z, hn::Zero(f));
    const V nx = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, ay), x), x);
    const V ny = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, ax), y), y);
    const V square = hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(z, z));
    const V s = hn::Div(one, hn::Sqrt(square));
    return {hn::Mul(nx, s), hn::Mul(ny, s), hn::Mul(z, s)};
}

void SeeCorners(const CutView& view, const CornerArrays& corners) {
    const D d;
    const F f;
    const hn::Rebind<int32_t, D> i;
    const hn::Rebind<uint32_t, F> u;
    const auto set = [&](const glm::vec3& v) HWY_ATTR {
        return Vector3<V>{hn::Set(f, v.x), hn::Set(f, v.y), hn::Set(f, v.z)};
    };
    const Vector3<V> right = set(view.right), down = set(view.down), forward = set(view.forward);
    const auto unit = hn::Set(f, view.unit), depth = hn::Set(f, view.pivot_depth);
    for (size_t c = 0; c < corners.count; c += hn::Lanes(d)) {
        const auto off = [&](int axis) HWY_ATTR {
            const auto steps = hn::PromoteTo(d, hn::LoadU(i, corners.lattice[axis] + c));
            const auto at = hn::Mul(steps, hn::Set(d, view.lattice_step));
            return hn::DemoteTo(f, hn::Sub(at, hn::Set(d, view.pivot[axis])));
        };
        const Vector3<V> at{off(0), off(1), off(2)};
        hn::StoreU(hn::Mul(unit, Dot(right, at)), f, corners.at[0] + c);
        hn::StoreU(hn::Mul(unit, Dot(down, at)), f, corners.at[1] + c);
        hn::StoreU(hn::Mul(unit, hn::Add(Dot(forward, at), depth)), f, corners.at[2] + c);
        if (!corners.codes) continue;
        const Vector3<V> n = DecodeNormals(hn::LoadU(u, corners.codes + c));
        hn::StoreU(Dot(right, n), f, corners.normal[0] + c);
        hn::StoreU(Dot(down, n), f, corners.normal[1] + c);
        hn::StoreU(Dot(forward, n), f, corners.normal[2] + c);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(SeeCorners);

void RunInView::see(const TriangleRun& run, const CutView& view) {
    right_ = view.right, down_ = view.down, forward_ = view.forward;
    CornerArrays corners{};
    corners.count = run.corners();
    corners.codes = run.has_normals() ? run.normal_codes() : nullptr;
    for (int axis = 0; axis < 3; ++axis) {
        at_[axis].resize(run.corners() + TriangleRun::kRoom),
            normal_[axis].resize(run.corners() + TriangleRun::kRoom);
        corners.lattice[axis] = run.positions(axis);
        corners.at[axis] = at_[axis].data(), corners.normal[axis] = normal_[axis].data();
    }
    HWY_DYNAMIC_DISPATCH(SeeCorners)(view, corners);
}

void RunInView::add(const TriangleRun& run, uint32_t triangle, uint32_t colour,
                    geom::TriangleBatch& batch) const {
    const glm::u32vec3& entries = run.entries(triangle);
    const bool is_smooth = run.is_smooth(triangle);
    glm::vec3 flat(0);
    if (!is_smooth) {
        const glm::dvec3 a(run.position(entries.x));
        const glm::dvec3 n =
            glm::cross(glm::dvec3(run.position(entries.y)) - a, glm::dvec3(run.position(entries.z)) - a);
        const double length = glm::length(n);
        if (!(length > 0)) return;
        const glm::vec3 unit(n / length);
        flat = {glm::dot(right_, unit), glm::dot(down_, unit), glm::dot(forward_, unit)};
    }
    const int to = batch.count++;
    for (int k = 0; k < 3; ++k) {
        const uint32_t e = entries[k];
        batch.x[k][to] = at_[0][e], batch.y[k][to] = at_[1][e], batch.z[k][to] = at_[2][e];
        batch.nx[k][to] = is_smooth ? normal_[0][e] : flat.x;
        batch.ny[k][to] = is_smooth ? normal_[1][e] : flat.y;
        batch.nz[k][to] = is_smooth ? normal_[2][e] : flat.z;
    }
    batch.colour[to] = colour;
}

}  // namespace splat
#endif
