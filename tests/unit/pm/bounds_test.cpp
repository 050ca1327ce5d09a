#include "pm/bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "test_meshes.h"

namespace {

using splat_test::Random;

TEST(Bounds, LatticesKeepTheirOwnValuesAndRoundOthersUp) {
    for (int code = 0; code <= pm::kMaxRadiusCode; ++code)
        EXPECT_EQ(pm::encode_radius(pm::decode_radius(uint8_t(code))), code);
    for (int code = 0; code < 256; ++code) EXPECT_EQ(pm::encode_error(pm::decode_error(uint8_t(code))), code);
    Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const double value = std::exp2(-45 + 47 * random.unit());
        const double radius = pm::decode_radius(pm::encode_radius(value));
        EXPECT_GE(radius, value);
        EXPECT_LE(radius, 2 * value);
        const double error = pm::decode_error(pm::encode_error(value));
        EXPECT_GE(error, value);
        EXPECT_LE(error, 1.19 * value);
    }
}

TEST(Bounds, NoErrorIsZeroAndNoneIsOverTheLattice) {
    EXPECT_EQ(pm::encode_error(0), 0);
    EXPECT_GT(pm::decode_error(0), 0);
    EXPECT_EQ(pm::encode_error(1e30), 255);
    EXPECT_EQ(pm::encode_radius(1e30), pm::kMaxRadiusCode);
    EXPECT_EQ(pm::decode_error(192), 1);
    EXPECT_EQ(pm::decode_error(194), std::sqrt(2.0));
}

TEST(Bounds, CodedConesHoldTheConesTheyCode) {
    Random random(2);
    int useful = 0;
    for (int i = 0; i < 5000; ++i) {
        const glm::dvec3 axis = random.direction();
        const double half_angle = 1.5 * random.unit() * random.unit();
        const pm::ConeCodes codes = pm::encode_cone(axis * std::exp2(-40 * random.unit()), half_angle);
        if (codes.angle == pm::kAnyDirection) continue;
        ++useful;
        const pm::Cone cone = pm::decode_cone(codes.axis, codes.angle);
        EXPECT_NEAR(cone.sine * cone.sine + cone.cosine * cone.cosine, 1, 1e-15);
        EXPECT_NEAR(glm::length(cone.axis), 1, 1e-15);
        const double off = std::acos(std::min(1.0, glm::dot(glm::normalize(axis), cone.axis)));
        EXPECT_GE(std::atan2(cone.sine, cone.cosine), off + half_angle);
        EXPECT_LE(std::atan2(cone.sine, cone.cosine), half_angle + 0.12);
    }
    EXPECT_GT(useful, 4000);
    EXPECT_EQ(pm::encode_cone({0, 0, 1}, 1.57).angle, pm::kAnyDirection);
}

TEST(Bounds, NormalsAreWithinADegree) {
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
        const glm::dvec3 normal = random.direction();
        const double cosine = glm::dot(pm::decode_normal(pm::encode_normal(normal)), normal);
        EXPECT_GE(cosine, std::cos(0.95 * std::numbers::pi / 180));
    }
    EXPECT_EQ(pm::decode_normal(pm::encode_normal({0, 0, 0})), glm::dvec3(0));
    for (const double z : {1.0, -1.0})
        EXPECT_EQ(pm::decode_normal(pm::encode_normal({0, 0, z})).z > 0, z > 0);
}

}  // namespace
