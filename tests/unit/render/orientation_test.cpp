#include "render/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

TEST(Orientation, AgreesWithIntegerArithmetic) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int64_t> far(-(int64_t(1) << 40), int64_t(1) << 40), near(-3, 3);
    int zeros = 0;
    for (int round = 0; round < 20000; ++round) {
        __int128 m[3][3];
        glm::dvec3 v[3];
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) {
                // The third vector is a combination of the others, off by little, so that rounding would
                // decide.
                const int64_t value =
                    i < 2 ? far(random)
                          : int64_t(m[0][k]) * (round % 7) - int64_t(m[1][k]) + near(random) / 3;
                m[i][k] = value;
                v[i][k] = double(value);
            }
        }
        const __int128 det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
        const int expected = det > 0 ? 1 : det < 0 ? -1 : 0;
        zeros += expected == 0;
        ASSERT_EQ(render::orientation(v[0], v[1], v[2]), expected) << "round " << round;
    }
    EXPECT_GT(zeros, 100);
}

TEST(Orientation, SeesOneUnitInTheLastPlace) {
    const glm::dvec3 a{0.1, 0.7, 1.3}, b{0.3, 0.2, 0.9};
    EXPECT_EQ(render::orientation(a, b, a), 0);
    EXPECT_EQ(render::orientation(a, b, b * 2.0), 0);
    // cross(a, b).z < 0: moving c along z by the least amount tells.
    for (const double scale : {1e-30, 1.0, 1e30}) {
        const glm::dvec3 c = a * scale;
        const int side = render::orientation(a, b, {c.x, c.y, std::nextafter(c.z, 1e300)}) -
                         render::orientation(a, b, {c.x, c.y, std::nextafter(c.z, -1e300)});
        EXPECT_EQ(side, -2) << scale;
    }
}

}  // namespace
