// Similarities: what text means, and that they go there and back.
#include "geom/similarity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace {

glm::dvec3 image(const char* text, const glm::dvec3& p) {
    return geom::parse_similarity(text, "test").point(p);
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double most) {
    EXPECT_LE(glm::length(a - b), most)
        << a.x << " " << a.y << " " << a.z << ", not " << b.x << " " << b.y << " " << b.z;
}

std::string refusal(const char* text) {
    try {
        geom::parse_similarity(text, "test");
    } catch (const core::Error& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST(Similarity, RefusesCommasWithoutNumbers) {
    for (const char* text : {",1,2,3", "1,,3", "1, ,3", "1,2,,", ",", ",,,"})
        EXPECT_EQ(refusal(text), "test: a comma without a number before it") << text;
    for (const char* text : {"1,2,3,", "1,2,3 ,\n"})
        EXPECT_EQ(refusal(text), "test: a comma without a number after it") << text;
}

TEST(Similarity, ReadsTranslationScaleAndTurns) {
    expect_near(image("1,2,3", {1, 0, 0}), {2, 2, 3}, 0);
    expect_near(image(" +1 2.5\t3e1\n", {1, 0, 0}), {2, 2.5, 30}, 0);
    expect_near(image("1,2,3,4", {1, 1, 0}), {5, 6, 3}, 1e-15);
    expect_near(image("0,0,0,1,90,0,0", {0, 1, 0}), {0, 0, 1}, 1e-15);
    expect_near(image("0,0,0,1,0,90,0", {0, 0, 1}), {1, 0, 0}, 1e-15);
    expect_near(image("0,0,0,1,0,0,90", {1, 0, 0}), {0, 1, 0}, 1e-15);
    expect_near(image("0,0,0,1,90,0,90", {0, 0, 1}), {1, 0, 0}, 1e-15);  // x first: to -y, and from there
}

TEST(Similarity, ReadsMatricesRowByRow) {
    expect_near(image("0 -2 0 1  2 0 0 2  0 0 2 3  0 0 0 1", {1, 0, 0}), {1, 4, 3}, 1e-15);
    const geom::Similarity mirror = geom::parse_similarity("-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1", "test");
    EXPECT_NEAR(glm::determinant(mirror.rotation), -1, 1e-15);
}

TEST(Similarity, TakesAMatrixOfSixDigitsForTheNearestRotation) {
    const geom::Similarity s =
        geom::parse_similarity("0.866025 -0.5 0 0  0.5 0.866026 0 0  0 0 1 0  0 0 0 1", "test");
    const glm::dmat3 product = glm::transpose(s.rotation) * s.rotation;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j, 1e-15);
    EXPECT_NEAR(s.rotation[0][1], 0.5, 2e-6);
}

TEST(Similarity, RefusesWhatIsNone) {
    for (const char* text : {"", "1,2", "1,2,3,4,5", "1,2,3,0", "1,2,3,-1", "1,2,3,1e200", "1,2,x", "1,2,nan",
                             "1,2,inf", "1,2,1e151", "1 0 0 0  0 2 0 0  0 0 1 0  0 0 0 1",
                             "1 1 0 0  0 1 0 0  0 0 1 0  0 0 0 1", "0 0 0 0  0 0 0 0  0 0 0 0  0 0 0 1",
                             "1 0 0 0  0 1 0 0  0 0 1 0  0 0 1 1", "1 0 0 0  0 1 0 0  0 0 1e-3 0  0 0 0 1"}) {
        EXPECT_TRUE(refusal(text).starts_with("test: ")) << text;
    }
}

TEST(Similarity, GoesThereAndBackAtAnyMagnitude) {
    for (const double magnitude : {1e-90, 1.0, 1e90}) {
        geom::Similarity s = geom::parse_similarity("1,-2,3,0.7,20,-100,55", "test");
        s.scale *= magnitude, s.translation *= magnitude;
        const glm::dvec3 p(0.3, -4, 5);
        EXPECT_LE(glm::length(s.inverse_point(s.point(p)) - p), 1e-14 * glm::length(p));
    }
}

TEST(Similarity, SpheresAroundSpheresHoldBoth) {
    const geom::Sphere a{{0, 0, 0}, 1}, b{{3, 0, 0}, 0.5}, inside{{0.2, 0, 0}, 0.3};
    const geom::Sphere both = geom::sphere_around(a, b);
    EXPECT_NEAR(both.radius, 2.25, 1e-15);
    EXPECT_NEAR(both.centre.x, 1.25, 1e-15);
    EXPECT_EQ(geom::sphere_around(a, inside).radius, 1);
    EXPECT_EQ(geom::sphere_around(inside, a).radius, 1);
}
