#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/pack_test.cpp"
#include <hwy/foreach_target.h>  // before what is compiled once for each target
// clang-format off
#include "core/pack-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace core {
namespace HWY_NAMESPACE {

// Of all masks, those by which the lanes of two vectors are not what a loop makes of them.
size_t MasksPackedWrongly() {
    constexpr size_t kMostLanes = 8;
    const hn::CappedTag<float, kMostLanes> d;
    const size_t lanes = hn::Lanes(d);
    float chosen[kMostLanes], a[kMostLanes], b[kMostLanes], got_a[kMostLanes], got_b[kMostLanes];
    size_t wrong = 0;
    for (size_t bits = 0; bits < size_t(1) << lanes; ++bits) {
        for (size_t k = 0; k < lanes; ++k) {
            chosen[k] = float(bits >> k & 1);
            a[k] = float(k + 1), b[k] = -a[k];
        }
        const Pack<decltype(d)> pack(hn::Ne(hn::LoadU(d, chosen), hn::Zero(d)));
        hn::StoreU(pack.of(hn::LoadU(d, a)), d, got_a);
        hn::StoreU(pack.of(hn::LoadU(d, b)), d, got_b);
        size_t count = 0;
        bool is_right = true;
        for (size_t k = 0; k < lanes; ++k) {
            if ((bits >> k & 1) == 0) continue;
            is_right = is_right && got_a[count] == a[k] && got_b[count] == b[k];
            ++count;
        }
        wrong += !(is_right && pack.count() == count);
    }
    return wrong;
}

}  // namespace HWY_NAMESPACE
}  // namespace core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace core {

HWY_EXPORT(MasksPackedWrongly);

namespace {

TEST(Pack, MovesTheLanesOfAnyMaskToTheFrontWithAnyInstructionSet) {
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        EXPECT_EQ(HWY_DYNAMIC_DISPATCH(MasksPackedWrongly)(), 0u) << hwy::TargetName(target);
        hwy::SetSupportedTargetsForTest(0);
    }
}

}  // namespace
}  // namespace core
#endif
