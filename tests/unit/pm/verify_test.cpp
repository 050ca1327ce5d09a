#include "pm/verify.h"

#include <gtest/gtest.h>

#include "test_models.h"

namespace {

using namespace pm_test;

const auto kVerify = [](const pm::Model& model) { pm::verify(model); };

class Verify : public testing::Test {
  protected:
    Bytes bytes = build_bytes(splat_test::bumpy_torus(16, 40));
    pm::Header header = pm::parse_header(bytes, "model");
    pm::Layout layout{header};

    template <class T>
    T& at(uint64_t offset) {
        return *reinterpret_cast<T*>(bytes.data() + offset);
    }
    std::string fault() const { return fault_of(repaired(bytes), kVerify); }
};

TEST_F(Verify, AcceptsWhatWasBuilt) {
    EXPECT_EQ(fault(), "");
}

TEST_F(Verify, NoticesAContentThatItsHashDoesNotKnow) {
    at<uint8_t>(layout.positions) ^= 1;
    EXPECT_TRUE(fault_of(bytes, kVerify).starts_with("content "));
}

TEST_F(Verify, NoticesBytesThatShouldBeZero) {
    const uint64_t used = layout.error + header.details;
    if (used == layout.radius) GTEST_SKIP() << "nothing to fill up";
    at<uint8_t>(used) = 1;
    EXPECT_EQ(fault(), "what fills its sections up is not 0");
}

TEST_F(Verify, NoticesAWrongDepth) {
    at<uint32_t>(40) += 1;
    EXPECT_TRUE(fault().starts_with("a depth of "));
}

TEST_F(Verify, NoticesANeedTooManyAndOneTooFew) {
    uint32_t with = pm::kNone, without = pm::kNone;
    for (uint32_t d = 1; d < header.details; ++d)
        (at<uint32_t>(layout.needs + 4 * d) == pm::kNone ? without : with) = d;
    ASSERT_NE(with, pm::kNone);
    Bytes whole = bytes;
    at<uint32_t>(layout.needs + 4 * with) = pm::kNone;
    EXPECT_EQ(fault(), "detail " + std::to_string(with) + " needs another detail than its cuts do");
    bytes = whole;
    at<uint32_t>(layout.needs + 4 * without) = 0;
    EXPECT_EQ(fault(), "detail " + std::to_string(without) + " needs another detail than its cuts do");
}

TEST_F(Verify, NoticesAFaceThatAnotherDetailAdds) {
    const uint32_t d = header.details / 2;
    std::swap(at<glm::u32vec3>(layout.faces + 24 * d), at<glm::u32vec3>(layout.faces + 24 * (d + 1)));
    EXPECT_EQ(fault(), "detail " + std::to_string(d) + " adds a left face that another one adds");
}

TEST_F(Verify, NoticesABoundThatIsTooSmall) {
    const uint32_t d = header.details / 2;
    const auto radius = at<uint8_t>(layout.radius + d);
    at<uint8_t>(layout.radius + d) = uint8_t(radius - 2);
    EXPECT_EQ(fault(), "detail " + std::to_string(d) + " has a sphere that does not hold its surface");
    at<uint8_t>(layout.radius + d) = radius;
    at<uint8_t>(layout.angle + d) = 0;
    EXPECT_EQ(fault(), "detail " + std::to_string(d) + " has a cone that does not hold its normals");
}

TEST_F(Verify, NoticesAMovedVertex) {
    auto& corner = at<glm::u16vec3>(layout.positions + 6 * (header.vertices() - 1));
    corner = corner.x < 8000 ? glm::u16vec3(16383) : glm::u16vec3(0);
    EXPECT_NE(fault().find("does not hold"), std::string::npos);
}

}  // namespace
