#include "geom/camera.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"

namespace {

using geom::Camera;
using geom::View;

// The largest departure from an orthonormal basis.
double basis_error(const View& view) {
    const glm::dvec3 axes[3] = {view.right, view.down, view.forward};
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double off = std::abs(glm::dot(axes[i], axes[j]) - (i == j ? 1 : 0));
            worst = std::isnan(off) ? off : std::max(worst, off);
        }
    return worst;
}

template <class Job>
std::string error_of(const Job& job) {
    try {
        job();
    } catch (const core::Error& error) {
        return error.what();
    }
    return "(no error)";
}

std::string parse_error_of(const std::string& text) {
    return error_of([&] { geom::parse_path(text, "p.jsonl"); });
}

// Any finite double, of any exponent within +-500 and either sign, sometimes a special one.
class AnyNumber {
  public:
    double operator()() {
        static constexpr double special[] = {0.0,     -0.0,
                                             1.0,     5e-324,
                                             -5e-324, 2.2250738585072014e-308,
                                             1e150,   -1e150,
                                             1e-150,  123456789012345678901234.0,
                                             0.1};
        if (random_() % 8 == 0) return special[random_() % std::size(special)];
        const uint64_t mantissa = random_() & ((uint64_t{1} << 52) - 1);
        const uint64_t exponent = 1023 - 497 + random_() % 994;  // keeps below 1e150
        return std::bit_cast<double>((random_() & (uint64_t{1} << 63)) | exponent << 52 | mantissa);
    }
    bool coin() { return random_() & 1; }

  private:
    std::mt19937_64 random_{11};
};

bool same_bits(double a, double b) {
    return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b);
}
bool same_bits(const glm::dvec3& a, const glm::dvec3& b) {
    return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}
bool same_bits(const std::optional<double>& a, const std::optional<double>& b) {
    return a.has_value() == b.has_value() && (!a || same_bits(*a, *b));
}

TEST(View, LooksRightDownAndForward) {
    const View view = geom::make_view({.eye = {0, 0, 5}}, 640, 480);
    EXPECT_EQ(view.right, glm::dvec3(1, 0, 0));
    EXPECT_EQ(view.down, glm::dvec3(0, -1, 0));
    EXPECT_EQ(view.forward, glm::dvec3(0, 0, -1));
    EXPECT_EQ(view.view_from_world({1, 2, 3}), glm::dvec3(1, -2, 2));
}

TEST(View, PutsTheFieldOfViewOnTheUpperAndLowerEdge) {
    for (const double fovy : {0.001, 1.0, 30.0, 90.0, 179.0}) {
        const View view = geom::make_view({.eye = {0, 0, 1}, .fovy_deg = fovy}, 640, 480);
        const double half = fovy * 3.14159265358979323846 / 360;
        // A point on the upper edge of the field of view, at unit depth.
        const glm::dvec3 p = view.view_from_world({0, std::tan(half), 0});
        EXPECT_NEAR(240 + view.focal_px * p.y / p.z, 0, 1e-9) << fovy;
    }
}

TEST(View, IsOrthonormalFrom1em150To1e150) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto direction = [&] { return glm::dvec3(normal(random), normal(random), normal(random)); };
    for (const double scale : {1e-150, 1e-100, 1e-30, 1.0, 1e30, 1e100, 1e149})
        for (const double up_scale : {1e-300, 1e-150, 1.0, 1e150, 1e300})
            for (int i = 0; i < 100; ++i) {
                const Camera camera{.eye = scale * (2.0 + direction()),
                                    .target = -scale * (2.0 + direction()),
                                    .up = up_scale * direction(),
                                    .fovy_deg = i % 2 ? 0.001 : 179};
                ASSERT_LE(basis_error(geom::make_view(camera, 100, 100)), 1e-15)
                    << geom::format_camera(camera);
            }
}

TEST(View, IsOrthonormalWhereUpIsNearlyAlongTheLineOfSight) {
    for (double off = 1; off > 1e-20; off /= 10) {
        const Camera camera{.eye = {0, 0, 0}, .target = {1, 2, 3}, .up = {1 + off, 2, 3 - off}};
        EXPECT_LE(basis_error(geom::make_view(camera, 100, 100)), 1e-15) << off;
    }
}

TEST(View, TakesTheLeastAlignedAxisWhereUpIsAlongTheLineOfSightOrZero) {
    for (const glm::dvec3 up : {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1e30), glm::dvec3(0)}) {
        const View view = geom::make_view({.eye = {0, 0, 1}, .up = up}, 100, 100);
        EXPECT_LE(basis_error(view), 1e-15);
        EXPECT_EQ(view.down, glm::dvec3(-1, 0, 0));  // x and y are aligned alike; the first is taken
    }
}

TEST(View, KeepsItsDirectionFarFromTheOrigin) {
    const glm::dvec3 far(1e12, -1e12, 1e12);
    const View view = geom::make_view({.eye = far + glm::dvec3(0, 0, 8), .target = far}, 100, 100);
    EXPECT_EQ(view.forward, glm::dvec3(0, 0, -1));
}

TEST(View, RefusesAnEyeAtItsTarget) {
    const std::string said = error_of([] {
        geom::make_view({.eye = {1, 2, 3}, .target = {1, 2, 3}}, 10, 10);
    });
    EXPECT_NE(said.find("\"eye\" and \"target\" are the same point (1, 2, 3)"), said.npos) << said;
    const double next = std::nextafter(1e12, 2e12);
    EXPECT_THROW(geom::make_view({.eye = {1e12, 0, 0}, .target = {next, 0, 0}}, 10, 10), core::Error);
    EXPECT_THROW(geom::make_view({.eye = {0, 0, 0}, .target = {1e-151, 0, 0}}, 10, 10), core::Error);
}

TEST(View, RefusesWhatCannotBeDrawn) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, infinity, -infinity, 1e151}) {
        EXPECT_THROW(geom::make_view({.eye = {0, bad, 0}}, 10, 10), core::Error);
        EXPECT_THROW(geom::make_view({.target = {0, bad, 0}}, 10, 10), core::Error);
        EXPECT_THROW(geom::make_view({.near = bad}, 10, 10), core::Error);
        EXPECT_THROW(geom::make_view({.far = bad}, 10, 10), core::Error);
    }
    for (const double bad : {nan, infinity}) {
        EXPECT_THROW(geom::make_view({.up = {0, bad, 0}}, 10, 10), core::Error);
        EXPECT_THROW(geom::make_view({.time_s = bad}, 10, 10), core::Error);
    }
    for (const double bad : {nan, infinity, 0.0, -30.0, 180.0, 1e-10})
        EXPECT_THROW(geom::make_view({.fovy_deg = bad}, 10, 10), core::Error) << bad;
    EXPECT_THROW(geom::make_view({.near = 0}, 10, 10), core::Error);
    EXPECT_THROW(geom::make_view({.near = 2, .far = 2}, 10, 10), core::Error);
    EXPECT_THROW(geom::make_view({}, 0, 10), core::Error);
    EXPECT_THROW(geom::make_view({}, 10, -1), core::Error);
}

TEST(CameraPath, ReadsBackBitForBit) {
    AnyNumber number;
    for (int i = 0; i < 20000; ++i) {
        Camera camera{.eye = {number(), number(), number()},
                      .target = {number(), number(), number()},
                      .up = {number(), number(), number()},
                      .fovy_deg = 1e-9 + std::fmod(std::abs(number()), 179),
                      .time_s = number()};
        if (number.coin()) camera.near = 1e-150 + std::abs(number()) / 2;
        if (number.coin()) camera.far = 1e150;
        if (error_of([&] { geom::check(camera); }) != "(no error)") continue;  // eye too near to target
        const std::string line = geom::format_camera(camera);
        const Camera read = geom::parse_camera(line, "line");
        ASSERT_TRUE(same_bits(read.eye, camera.eye) && same_bits(read.target, camera.target) &&
                    same_bits(read.up, camera.up) && same_bits(read.fovy_deg, camera.fovy_deg) &&
                    same_bits(read.time_s, camera.time_s) && same_bits(read.near, camera.near) &&
                    same_bits(read.far, camera.far))
            << line;
        ASSERT_EQ(geom::format_camera(read), line);
    }
}

TEST(CameraPath, IsWrittenShort) {
    const Camera camera{.eye = {0.1, -0.0, 1e100}, .time_s = 1.0 / 3, .near = 0.5};
    EXPECT_EQ(geom::format_camera(camera),
              "{\"eye\":[0.1,-0.0,1e+100],\"target\":[0,0,0],\"up\":[0,1,0],\"fovy\":30,"
              "\"t\":0.3333333333333333,\"near\":0.5}\n");
}

TEST(CameraPath, IsNotWrittenWhereANumberIsNotFinite) {
    EXPECT_THROW(geom::format_camera({.time_s = std::numeric_limits<double>::infinity()}), core::Error);
}

TEST(CameraPath, FillsInWhatMayBeLeftOut) {
    const auto path = geom::parse_path(
        "\n{\"eye\":[0,0,2],\"target\":[0,0,0]}\r\n "
        "\t\r\n{\"target\":[0,0,1],\"eye\":[1,2,3],\"colour\":{\"a\":[]}}",
        "p");
    ASSERT_EQ(path.size(), 2u);
    EXPECT_EQ(path[1].eye, glm::dvec3(1, 2, 3));
    EXPECT_EQ(path[1].up, glm::dvec3(0, 1, 0));
    EXPECT_EQ(path[1].fovy_deg, 30);
    EXPECT_EQ(path[0].time_s, 0);
    EXPECT_EQ(path[1].time_s, 1.0 / 24);
    EXPECT_FALSE(path[1].near || path[1].far);
}

TEST(CameraPath, SaysWhichLineAndKeyIsWrong) {
    const std::string good = "{\"eye\":[0,0,2],\"target\":[0,0,0]}\n";
    EXPECT_EQ(parse_error_of(good + "\n{\"eye\":[0,0,2]}"), "p.jsonl: line 3: \"target\" is missing");
    EXPECT_EQ(parse_error_of("{\"eye\":\"far\",\"target\":[0,0,0]}"),
              "p.jsonl: line 1: \"eye\": expected 3 numbers, found string");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2],\"target\":[0,0,0]}"),
              "p.jsonl: line 1: \"eye\": expected 3 numbers, found 2");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,null],\"target\":[0,0,0]}"),
              "p.jsonl: line 1: \"eye\": expected a number, found null");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"target\":[0,0,0],\"fovy\":true}"),
              "p.jsonl: line 1: \"fovy\": expected a number, found boolean");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"target\":[0,0,0],\"fovy\":180}"),
              "p.jsonl: line 1: \"fovy\" is 180 degrees, expected 1e-09 up to, not including, 180");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"target\":[0,0,0],\"near\":3,\"far\":2}"),
              "p.jsonl: line 1: \"near\" is 3, not before \"far\", 2");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"target\":[0,0,1e999]}"),
              "p.jsonl: line 1: a number is beyond the range of double");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"target\":[0,0,1e151]}"),
              "p.jsonl: line 1: \"target\" has a coordinate of 1e+151, beyond 1e+150");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],\"eye\":[1,2,3],\"target\":[0,0,0]}"),
              "p.jsonl: line 1: \"eye\" is there twice");
    EXPECT_EQ(parse_error_of("[1,2]"), "p.jsonl: line 1: expected a JSON object, found array");
    EXPECT_EQ(parse_error_of("eye 1 2 3"), "p.jsonl: line 1: column 1: not JSON");
    EXPECT_EQ(parse_error_of("{\"eye\":[1,2,3],}"), "p.jsonl: line 1: column 16: not JSON");
    EXPECT_EQ(parse_error_of("{\"eye\":[nan,2,3]}"), "p.jsonl: line 1: column 10: not JSON");
}

TEST(CameraPath, KeepsThePlacesOfLinesThatAreWrong) {
    const auto frames = geom::parse_frames(
        "{\"eye\":[0,0,2],\"target\":[0,0,0]}\n\n"
        "{\"eye\":[1,2,3],\"target\":[1,2,3]}\n"
        "not JSON\n"
        "{\"eye\":[0,0,3],\"target\":[0,0,0]}\n",
        "p.jsonl");
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_EQ(frames[0].fault, "");
    EXPECT_EQ(frames[1].fault.find("p.jsonl: line 3: \"eye\" and \"target\" are the same point"), 0u);
    EXPECT_EQ(frames[2].fault.find("p.jsonl: line 4: "), 0u);
    EXPECT_EQ(frames[3].fault, "");
    EXPECT_EQ(frames[3].camera.eye.z, 3);
    EXPECT_EQ(frames[3].camera.time_s, 3 / geom::kDefaultFps);
}

TEST(CameraPath, RefusesAPathWithoutACamera) {
    for (const char* text : {"", "\n", " \r\n\t\n"})
        EXPECT_EQ(parse_error_of(text), "p.jsonl: holds no camera");
}

TEST(CameraPath, RefusesLinesBeyond64KiB) {
    const std::string key = "{\"eye\":[0,0,2],\"target\":[0,0,0],\"note\":\"";
    const std::string fits = key + std::string(65536 - key.size() - 2, 'x') + "\"}";
    EXPECT_EQ(geom::parse_path(fits, "p").size(), 1u);
    EXPECT_EQ(parse_error_of(fits + " "), "p.jsonl: line 1: is 65537 bytes long, at most 65536 are read");
}

TEST(CameraPath, BearsTheDeepestNestingThatFitsInALine) {
    const std::string deep = std::string(30000, '[') + std::string(30000, ']');
    EXPECT_EQ(geom::parse_path("{\"eye\":[0,0,2],\"target\":[0,0,0],\"x\":" + deep + "}", "p").size(), 1u);
    EXPECT_EQ(parse_error_of(std::string(65536, '[')), "p.jsonl: line 1: column 65537: not JSON");
}

}  // namespace

TEST(PartOf, KeepsWhereAPointIsInThePicture) {
    geom::Camera camera;
    geom::View view = geom::make_view(camera, 101, 50);
    view.shift_px = {3.25, -1};
    const geom::View part = geom::part_of(geom::part_of(view, 10, 5, 80, 40), 17, 6, 9, 31);
    EXPECT_EQ(part.principal(), view.principal());
    EXPECT_EQ(part.picture_width(), 101);
    EXPECT_EQ(part.picture_height(), 50);
    EXPECT_EQ(part.principal_in_raster(), view.principal() - glm::dvec2(17, 6));
}

TEST(Subdivided, PutsAPointAtTheSamePlaceInFinerPixels) {
    geom::Camera camera;
    geom::View view = geom::part_of(geom::make_view(camera, 101, 50), 3, 4, 60, 30);
    view.shift_px = {3.25, -1};
    const geom::View fine = geom::subdivided(view, 4);
    EXPECT_EQ(fine.width, 240);
    EXPECT_EQ(fine.picture_height(), 200);
    EXPECT_EQ(fine.principal_in_raster(), 4.0 * view.principal_in_raster());
    EXPECT_EQ(fine.focal_px, 4 * view.focal_px);
}
