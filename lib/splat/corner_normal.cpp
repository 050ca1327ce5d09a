#include "splat/corner_normal.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/corner_normal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef QS_SPLAT_CORNER_NORMAL_ONCE
#define QS_SPLAT_CORNER_NORMAL_ONCE
namespace splat {
namespace {

constexpr double kMiddle = (kCornerNormalSteps - 1) / 2;

struct alignas(16) FaceSum {
    float x = 0, y = 0, z = 0, unused = 0;
};

}  // namespace
}  // namespace splat
#endif

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// encode_corner_normal() in single precision, a lane a corner; `sums` and `codes` have room for a vector
// more.
void EncodeSums(const FaceSum* sums, size_t count, uint32_t* codes) {
    const hn::ScalableTag<float> d;
    const hn::RebindToUnsigned<decltype(d)> du;
    const hn::RebindToSigned<decltype(d)> di;
    using V = hn::Vec<decltype(d)>;
    const V one = hn::Set(d, 1.0f), middle = hn::Set(d, float(kMiddle)),
            half = hn::Set(d, float(kMiddle + 0.5));
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        V x, y, z, unused;
        hn::LoadInterleaved4(d, &sums[i].x, x, y, z, unused);
        const V sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
        const auto has_any = hn::Gt(sum, hn::Zero(d));
        const V u = hn::Div(x, sum), v = hn::Div(y, sum);
        const auto below = hn::Lt(z, hn::Zero(d));
        const V fu = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(v)), u), u);
        const V fv = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(u)), v), v);
        const auto step = [&](V w) HWY_ATTR {
            const V steps = hn::IfThenElseZero(has_any, hn::Add(hn::Mul(w, middle), half));
            return hn::BitCast(du, hn::ConvertTo(di, steps));
        };
        hn::StoreU(hn::Or(step(fu), hn::ShiftLeft<kCornerNormalBits>(step(fv))), du, codes + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(EncodeSums);

uint32_t encode_corner_normal(const glm::dvec3& n) {
    const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    if (!(sum > 0)) return 0;
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        const double folded = std::copysign(1 - std::fabs(y), x);
        y = std::copysign(1 - std::fabs(x), y), x = folded;
    }
    const auto step = [&](double v) { return uint32_t(v * kMiddle + (kMiddle + 0.5)); };
    return step(x) | step(y) << kCornerNormalBits;
}

glm::vec3 decode_corner_normal(uint32_t code) {
    constexpr float kHalf = float(kMiddle);
    const float x = (float(code & 4095u) - kHalf) / kHalf, y = (float(code >> 12 & 4095u) - kHalf) / kHalf;
    const float ax = std::fabs(x), ay = std::fabs(y);
    glm::vec3 n(x, y, 1.0f - ax - ay);
    if (n.z < 0.0f) n.x = std::copysign(1.0f - ay, x), n.y = std::copysign(1.0f - ax, y);
    const float s = 1.0f / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {n.x * s, n.y * s, n.z * s};
}

void tell_corner_normals(std::span<const glm::u32vec3> triangles, const std::vector<int32_t> (&positions)[3],
                         std::span<uint32_t> codes) {
    constexpr size_t kRoom = 64;  // more than any vector
    static thread_local std::vector<FaceSum> sums;
    static thread_local std::vector<uint32_t> found;
    sums.assign(codes.size() + kRoom, {});
    found.resize(sums.size());
    const int32_t *x = positions[0].data(), *y = positions[1].data(), *z = positions[2].data();
    for (const glm::u32vec3& t : triangles) {
        // Corners may be 2^32 apart.
        const auto edge = [&](const int32_t* p, uint32_t to) { return float(int64_t(p[to]) - p[t.x]); };
        const float px = edge(x, t.y), py = edge(y, t.y), pz = edge(z, t.y);
        const float qx = edge(x, t.z), qy = edge(y, t.z), qz = edge(z, t.z);
        const float nx = py * qz - pz * qy, ny = pz * qx - px * qz, nz = px * qy - py * qx;
        for (int k = 0; k < 3; ++k) {
            FaceSum& sum = sums[t[k]];
            sum.x += nx, sum.y += ny, sum.z += nz;
        }
    }
    HWY_DYNAMIC_DISPATCH(EncodeSums)(sums.data(), codes.size(), found.data());
    std::copy_n(found.begin(), codes.size(), codes.begin());
}

}  // namespace splat
#endif
