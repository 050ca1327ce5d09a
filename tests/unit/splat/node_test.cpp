// The node code: what codes mean, computed a second time in double precision from the words of qs(5), and
// what no code can break.
#include "splat/node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_meshes.h"

using namespace splat_test;

namespace {

struct Codes {
    uint16_t attitude, place;
    uint8_t shape;
};

Codes random_codes(Random& random) {
    const uint64_t bits = random.bits();
    return {uint16_t(bits), uint16_t(bits >> 16), uint8_t(bits >> 32 & 15)};
}

glm::dvec3 unit(const glm::dvec3& n) {
    return n / glm::length(n);
}

// The direction of a code on the octahedron, or on the parent's cap.
glm::dvec3 expected_normal(uint32_t code, const glm::dvec3 axes[3], int parent_cone) {
    const uint32_t column = code % 31, row = std::min(code / 31, 30u);
    const double x = (double(column) - 15) / 15, y = (double(row) - 15) / 15;
    if (parent_cone < 0) {
        const double z = 1 - std::fabs(x) - std::fabs(y);
        if (z >= 0) return unit({x, y, z});
        return unit({std::copysign(1 - std::fabs(y), x), std::copysign(1 - std::fabs(x), y), z});
    }
    // Stereographic: a point of the plane at tan(a / 2) is at angle a from the axis.
    const double px = x * double(splat::kConeTan[parent_cone]), py = y * double(splat::kConeTan[parent_cone]);
    const double angle = 2 * std::atan(std::hypot(px, py)), turn = std::atan2(py, px);
    const glm::dvec3 across = std::cos(turn) * axes[0] + std::sin(turn) * axes[1];
    return unit(std::sin(angle) * across + std::cos(angle) * axes[2]);
}

// Right-handed axes with n last.  The sense of n.z = -0 is a matter of single precision: `sign` is that of
// the decoded n.z.
void expected_axes(const glm::dvec3& n, double sign, glm::dvec3 axes[3]) {
    axes[0] = {1 - sign * n.x * n.x / (sign + n.z), -sign * n.x * n.y / (sign + n.z), -sign * n.x};
    axes[1] = {-n.x * n.y / (sign + n.z), sign - n.y * n.y / (sign + n.z), -n.y};
    axes[2] = n;
}

double step(double u, double linear) {
    return u * (linear + (1 - linear) * std::fabs(u));
}

glm::dvec3 expected_offset(uint32_t place, const glm::dvec3 axes[3]) {
    const uint32_t across = place >> 4 & 127;
    glm::dvec3 p(step((double(across % 11) - 5) / 5, double(splat::kAcrossLinear)),
                 step((double(across / 11) - 5) / 5, double(splat::kAcrossLinear)),
                 step((double(place >> 11) - 15.5) / 16, 0.35));
    if (const double length = glm::length(p); length > 1) p /= length;
    p *= (1 + double(splat::kSlack)) * (1 - double(splat::kRadius[place & 15]));
    return p.x * axes[0] + p.y * axes[1] + p.z * axes[2];
}

splat::Node random_parent(Random& random) {
    splat::Node parent;
    parent.centre = random.direction();
    parent.radius = float(std::exp2(-20 * random.unit()));
    parent.normal = glm::vec3(random.direction());
    parent.cone = int(random.bits() % (splat::kConeCount + 1)) - 1;
    return parent;
}

splat::Node decode(const Codes& c, const splat::Node& parent) {
    return splat::decode_node(c.attitude, c.place, c.shape, 0, parent, splat::frame_about(parent.normal));
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

TEST(NodeCode, IsWhatDoublePrecisionSays) {
    Random random(1);
    for (int i = 0; i < 200000; ++i) {
        const splat::Node parent = random_parent(random);
        const Codes c = random_codes(random);
        const splat::Node node = decode(c, parent);
        glm::dvec3 axes[3];
        expected_axes(glm::dvec3(parent.normal), std::copysign(1.0, double(parent.normal.z)), axes);
        const glm::dvec3 normal = expected_normal(c.attitude >> 5 & 1023, axes, parent.cone);
        ASSERT_LT(glm::length(normal - glm::dvec3(node.normal)), 1e-6) << i;
        expected_axes(normal, std::copysign(1.0, double(node.normal.z)), axes);
        const glm::dvec3 offset = expected_offset(c.place, axes),
                         got = (node.centre - parent.centre) / double(parent.radius);
        ASSERT_LT(glm::length(offset - got), 1.2e-6) << i;
        ASSERT_FLOAT_EQ(node.radius, parent.radius * splat::kRadius[c.place & 15]);
        ASSERT_EQ(node.flatness, splat::kFlatness[c.shape & 3]);
        const int error = (c.attitude >> 15) * 4 + (c.shape >> 2);
        ASSERT_FLOAT_EQ(node.error, node.radius * splat::kErrorOfRadius[c.shape & 3][error]);
        ASSERT_EQ(node.children, c.attitude & 7);
        const int cone = c.attitude >> 3 & 3;
        ASSERT_EQ(node.cone, cone == 3 ? -1 : std::min(std::max(parent.cone, 0) + 2 - cone, 7));
    }
}

// |p| + 1.12 r <= 1.12 R for each place code, under any normal: exhaustive in the place.
TEST(NodeCode, NestsForAnyBitPattern) {
    Random random(2);
    const double slack = 1 + double(splat::kSlack);
    for (uint32_t place = 0; place < 65536; ++place) {
        const glm::vec3 normal(random.direction());
        const double offset =
            glm::length(glm::dvec3(splat::decode_offset(place, splat::frame_about(normal))));
        ASSERT_LE(offset + slack * double(splat::kRadius[place & 15]), slack * (1 + 1e-6)) << place;
    }
}

TEST(NodeCode, NestsDownChainsOfRandomCodes) {
    Random random(3);
    const double slack = 1 + double(splat::kSlack);
    for (int chain = 0; chain < 5000; ++chain) {
        splat::Node parent = random_parent(random);
        parent.centre = glm::dvec3(0), parent.radius = 1;
        const splat::Node root = parent;
        for (int depth = 0; depth < 25; ++depth) {
            const splat::Node node = decode(random_codes(random), parent);
            const double reach = glm::length(node.centre - parent.centre) + slack * double(node.radius);
            ASSERT_LE(reach, slack * double(parent.radius) * (1 + 1e-5) + 1e-15)
                << chain << " at depth " << depth;
            ASSERT_LE(glm::length(node.centre - root.centre) + slack * double(node.radius),
                      slack * (1 + 1e-5) + 1e-15);
            ASSERT_NEAR(glm::length(glm::dvec3(node.normal)), 1, 1e-6);
            parent = node;
        }
    }
}

TEST(NodeCode, FramesAreOrthonormalForEveryNormal) {
    Random random(4);
    for (int i = 0; i < 100000; ++i) {
        glm::dvec3 n = random.direction();
        if (i % 3 == 0)
            n = glm::normalize(glm::dvec3(n.x * 1e-6, n.y * 1e-6, i % 2 ? 1 : -1));  // about the poles
        if (i % 3 == 1) n = glm::normalize(glm::dvec3(n.x, n.y, n.z * 1e-8));        // about the equator
        const splat::Frame f = splat::frame_about(glm::vec3(n));
        ASSERT_NEAR(glm::dot(f.t1, f.t2), 0, 1e-6);
        ASSERT_NEAR(glm::dot(f.t1, f.n), 0, 1e-6);
        ASSERT_NEAR(glm::dot(f.t2, f.n), 0, 1e-6);
        ASSERT_NEAR(glm::length(f.t1), 1, 1e-6);
        ASSERT_NEAR(glm::length(f.t2), 1, 1e-6);
    }
}

TEST(NodeCode, ConeTablesAgree) {
    for (int k = 0; k < splat::kConeCount; ++k) {
        const double half = std::acos(double(splat::kConeCos[k]));
        EXPECT_NEAR(double(splat::kConeSin[k]), std::sin(half), 1e-6) << k;
        EXPECT_NEAR(double(splat::kConeTan[k]), std::tan(half / 2), 2e-6) << k;
        EXPECT_TRUE(k == 0 || splat::kConeCos[k] > splat::kConeCos[k - 1]) << k;
    }
}

TEST(NodeCode, EveryCapNormalLiesInTheSquareAboutTheCone) {
    const splat::Frame frame = splat::frame_about({0, 0, 1});
    for (int cone = 0; cone < splat::kConeCount; ++cone) {
        const double most = 2 * std::atan(std::sqrt(2.0) * double(splat::kConeTan[cone]));
        for (uint32_t code = 0; code < 1024; ++code)
            ASSERT_LE(angle_between({0, 0, 1}, glm::dvec3(splat::decode_normal(code, frame, cone))),
                      most + 1e-6);
        const uint32_t middle = uint32_t(splat::kNormalSteps * splat::kNormalSteps / 2);
        EXPECT_EQ(splat::decode_normal(middle, frame, cone), glm::vec3(0, 0, 1))
            << "the axis itself has a code";
    }
}

TEST(NodeCode, ColoursComeBackWithinHalfAStep) {
    for (unsigned v = 0; v < 256; ++v) {
        const glm::u8vec3 c = splat::decode_colour(splat::encode_colour(glm::u8vec3(v, v, v)));
        EXPECT_LE(std::abs(int(c.r) - int(v)), 4) << v;
        EXPECT_LE(std::abs(int(c.g) - int(v)), 2) << v;
        EXPECT_LE(std::abs(int(c.b) - int(v)), 4) << v;
    }
}
