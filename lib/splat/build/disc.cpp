#include "splat/build/disc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/build/disc.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/pack-inl.h"
#include "splat/build/cells-inl.h"
#include "splat/vector3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using core::HWY_NAMESPACE::Pack;

using D = hn::CappedTag<float, 8>;
using V = hn::Vec<D>;

using V3 = Vector3<V>;

// Discs in another disc's frame: centre (relative to the other's), normal, radius and error.
struct Discs {
    static constexpr size_t kMost = 64;
    size_t count;
    alignas(64) float x[kMost], y[kMost], z[kMost], nx[kMost], ny[kMost], nz[kMost], radius[kMost],
        error[kMost];
};

void TurnDiscs(const Node& node, std::span<const Node* const> parts, Discs& discs) {
    const D d;
    discs.count = std::min(parts.size(), Discs::kMost);
    for (size_t k = 0; k < discs.count; ++k) {
        const Node& c = *parts[k];
        discs.x[k] = float(c.centre.x - node.centre.x), discs.y[k] = float(c.centre.y - node.centre.y),
        discs.z[k] = float(c.centre.z - node.centre.z);
        discs.nx[k] = c.normal.x, discs.ny[k] = c.normal.y, discs.nz[k] = c.normal.z;
        discs.radius[k] = c.radius, discs.error[k] = c.error;
    }
    const Frame frame = frame_about(node.normal);
    const auto turn = [&](float* x, float* y, float* z) {
        const V3 p{hn::Load(d, x), hn::Load(d, y), hn::Load(d, z)};
        hn::Store(Dot(Set3(d, frame.t1), p), d, x), hn::Store(Dot(Set3(d, frame.t2), p), d, y),
            hn::Store(Dot(Set3(d, frame.n), p), d, z);
    };
    for (size_t k = 0; k < discs.count; k += hn::Lanes(d))
        turn(discs.x + k, discs.y + k, discs.z + k), turn(discs.nx + k, discs.ny + k, discs.nz + k);
}

float NestedError(const Node& node, std::span<const Node* const> parts, bool is_fine) {
    using S = hn::Vec<Sectors>;
    const Sectors d;
    Discs discs;
    TurnDiscs(node, parts, discs);
    const auto square_of = [&](size_t k, S px, S py) HWY_ATTR {
        const S x = hn::Sub(px, hn::Set(d, discs.x[k])), y = hn::Sub(py, hn::Set(d, discs.y[k])),
                z = hn::Set(d, -discs.z[k]);
        const S along =
            hn::Add(hn::Add(hn::Mul(x, hn::Set(d, discs.nx[k])), hn::Mul(y, hn::Set(d, discs.ny[k]))),
                    hn::Mul(z, hn::Set(d, discs.nz[k])));
        const S square = hn::Mul(along, along);
        const S all = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
        const S across = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(all, square)));
        const S beyond = hn::Max(hn::Zero(d), hn::Sub(across, hn::Set(d, discs.radius[k])));
        return hn::Add(hn::Mul(beyond, beyond), square);
    };
    const auto error = [&](size_t k) { return discs.error[k]; };
    // No smaller error is told apart.
    const float enough = node.radius * kErrorOfRadius[flatness_code(node)][0];
    Cells cells(node.radius, discs.count, square_of, error);
    return is_fine ? cells.fine_bound(enough) : cells.bound(enough);
}

// Nodes [first, first + count) of each group whose spheres, times `part`, touch the one of `node`.
std::span<const uint32_t> Touching(const Spheres& spheres, std::span<const NodeRange> groups, uint32_t node,
                                   float part, std::vector<uint32_t>& room) {
    const hn::CappedTag<float, 8> d;  // a sibling group a vector
    const hn::Rebind<uint32_t, decltype(d)> du;
    using W = hn::Vec<decltype(d)>;
    const W x = hn::Set(d, spheres.x[node]), y = hn::Set(d, spheres.y[node]), z = hn::Set(d, spheres.z[node]),
            radius = hn::Set(d, spheres.radius[node]);
    size_t count = 0, most = kSpare;
    for (const NodeRange& group : groups) most += group.count;
    if (room.size() < most) room.resize(2 * most);
    uint32_t* const out = room.data();
    for (const NodeRange& group : groups)
        for (uint32_t k = 0; k < group.count; k += uint32_t(hn::Lanes(d))) {
            const size_t i = group.first + k;
            const Vector3<W> to{hn::Sub(hn::LoadU(d, &spheres.x[i]), x),
                                hn::Sub(hn::LoadU(d, &spheres.y[i]), y),
                                hn::Sub(hn::LoadU(d, &spheres.z[i]), z)};
            const W reach = hn::Add(hn::Mul(hn::Set(d, part), hn::LoadU(d, &spheres.radius[i])), radius);
            const auto touching =
                hn::And(hn::FirstN(d, group.count - k), hn::Lt(Dot(to, to), hn::Mul(reach, reach)));
            const Pack<decltype(du)> pack(hn::RebindMask(du, touching));
            hn::StoreU(pack.of(hn::Iota(du, uint32_t(i))), du, out + count);
            count += pack.count();
        }
    return {out, count};
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(NestedError);
HWY_EXPORT(Touching);

float nested_error(const Node& node, std::span<const Node* const> parts, bool is_fine) {
    return HWY_DYNAMIC_DISPATCH(NestedError)(node, parts, is_fine);
}

std::span<const uint32_t> touching(const Spheres& spheres, std::span<const NodeRange> ranges, uint32_t node,
                                   float part, std::vector<uint32_t>& room) {
    return HWY_DYNAMIC_DISPATCH(Touching)(spheres, ranges, node, part, room);
}

}  // namespace splat
#endif
