#include "render/splatter.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "core/parallel.h"
#include "render/shading.h"

namespace {

using glm::dvec3;
using render::Frame;
using render::Shade;
using render::SplatBatch;
using render::SplatKind;
using render::Splatter;
using render::SplatterOptions;

struct Splat {
    glm::vec3 centre;
    float radius;
    glm::vec3 normal;
    float flatness;
    uint32_t colour = 0x00808080;
};

geom::View view_of(int width, int height, double focal_px) {
    geom::View view;
    view.width = width;
    view.height = height;
    view.focal_px = focal_px;
    return view;
}

glm::vec3 random_unit(std::mt19937& random) {
    std::normal_distribution<float> normal;
    for (;;) {
        const glm::vec3 v{normal(random), normal(random), normal(random)};
        if (glm::length(v) > 0.01f) return glm::normalize(v);
    }
}

// Task t takes the t-th of `task_count` equal parts of the splats.
void draw(Splatter& splatter, const geom::View& view, const SplatterOptions& options,
          const std::vector<Splat>& splats, size_t task_count, Frame& frame) {
    splatter.begin(view, options, task_count);
    core::parallel_for(task_count, [&](size_t task) {
        const auto batch = std::make_unique<SplatBatch>();
        const size_t begin = splats.size() * task / task_count, end = splats.size() * (task + 1) / task_count;
        for (size_t i = begin; i < end; ++i) {
            const size_t k = static_cast<size_t>(batch->count++);
            const Splat& s = splats[i];
            batch->x[k] = s.centre.x, batch->y[k] = s.centre.y, batch->z[k] = s.centre.z;
            batch->nx[k] = s.normal.x, batch->ny[k] = s.normal.y, batch->nz[k] = s.normal.z;
            batch->radius[k] = s.radius, batch->flatness[k] = s.flatness, batch->colour[k] = s.colour;
            if (batch->count == SplatBatch::kCapacity || i + 1 == end) {
                splatter.add(task, *batch);
                batch->count = 0;
            }
        }
        splatter.end_task(task);
    });
    splatter.finish(frame);
}

Frame draw(const geom::View& view, const SplatterOptions& options, const std::vector<Splat>& splats,
           size_t task_count = 1) {
    Splatter splatter;
    Frame frame;
    draw(splatter, view, options, splats, task_count, frame);
    return frame;
}

size_t covered(const Frame& frame) {
    return static_cast<size_t>(
        std::count_if(frame.depth.begin(), frame.depth.end(), [](float z) { return std::isfinite(z); }));
}

dvec3 ray_of(const geom::View& view, double px, double py) {
    return {(px - 0.5 * view.width) / view.focal_px, (py - 0.5 * view.height) / view.focal_px, 1.0};
}

// Least value over the ray (before the eye) of the quadric that is 1 on the ellipsoid, in double: how far
// out, relative to the ellipsoid, the ray passes; and the depth where it meets the polar plane of the eye.
struct Passing {
    double relative;
    double depth;
};

Passing pass(const Splat& s, const dvec3& ray) {
    const dvec3 n(s.normal);
    const double radius = s.radius, rho = s.flatness;
    // Scaled so that the ellipsoid is the unit sphere: along the normal by 1/rho.
    const auto to_sphere = [&](const dvec3& v) { return (v + (1 / rho - 1) * glm::dot(n, v) * n) / radius; };
    const dvec3 p = to_sphere(dvec3(s.centre)), d = to_sphere(ray);
    const double depth = glm::dot(p, p) / glm::dot(d, p);
    return {glm::length(glm::cross(d, p)) / glm::length(d), depth};
}

struct Case {
    const char* name;
    double flatness_low, flatness_high;
    double ratio_low, ratio_high;  // of R to z
    double focal_px;
    double growth;  // how far out, relative to the ellipsoid, may be covered, if it is more than 1e-3 px
};

void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

class Outline : public testing::TestWithParam<Case> {};

// Splats at any depth and any slant, alone on a screen: every pixel against the ray through its centre.
TEST_P(Outline, IsThatOfTheEllipsoid) {
    const Case& c = GetParam();
    const geom::View view = view_of(203, 149, c.focal_px);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    Splatter splatter;
    Frame frame;
    size_t pixels = 0;
    for (int round = 0; round < 400; ++round) {
        const double z = std::pow(10.0, -3 + 9 * unit(random));
        const auto between = [&](double low, double high) {
            return low * std::pow(high / low, unit(random));
        };
        Splat s;
        s.radius = static_cast<float>(z * between(c.ratio_low, c.ratio_high));
        s.flatness = static_cast<float>(between(c.flatness_low, c.flatness_high));
        const dvec3 ray =
            ray_of(view, view.width * (1.2 * unit(random) - 0.1), view.height * (1.2 * unit(random) - 0.1));
        s.centre = glm::vec3(z * ray);
        s.normal = random_unit(random);
        // Every third one edge-on to its ray, where a polynomial expanded carelessly cancels.
        if (round % 3 == 0) {
            const dvec3 across = glm::cross(dvec3(s.normal), glm::normalize(ray));
            if (glm::length(across) > 0.1) s.normal = glm::vec3(glm::normalize(across));
        }
        draw(splatter, view, {SplatKind::ellipse, {Shade::flat}}, {s}, 1, frame);

        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const float depth = frame.depth[size_t(y * view.width + x)];
                const Passing at = pass(s, ray_of(view, x + 0.5, y + 0.5));
                if (at.relative < 1 - 1e-4) {
                    ASSERT_TRUE(std::isfinite(depth))
                        << "hole at " << x << "," << y << " round " << round << " by " << at.relative;
                }
                if (!std::isfinite(depth)) continue;
                ++pixels;
                EXPECT_NEAR(depth / at.depth, 1.0, 2e-5)
                    << "depth at " << x << "," << y << " round " << round;
                if (at.relative <= 1 + c.growth) continue;
                // Outside by so many pixels: along the gradient of the relative distance.
                const double h = 1e-4;
                const double gx = (pass(s, ray_of(view, x + 0.5 + h, y + 0.5)).relative - at.relative) / h;
                const double gy = (pass(s, ray_of(view, x + 0.5, y + 0.5 + h)).relative - at.relative) / h;
                ASSERT_LT((at.relative - 1) / std::hypot(gx, gy), 1e-3)
                    << "too far out at " << x << "," << y << " round " << round << " by " << at.relative;
            }
        }
    }
    EXPECT_GT(pixels, 100u);
}

INSTANTIATE_TEST_SUITE_P(Splatter, Outline,
                         testing::Values(Case{"balls", 0.9, 1, 0.01, 0.5, 150, 2e-5},
                                         Case{"flat", 0.01, 0.02, 0.01, 0.5, 150, 2e-5},
                                         Case{"any", 0.01, 1, 0.001, 0.9, 150, 2e-5},
                                         Case{"nearly_at_the_eye", 0.01, 1, 0.8, 0.999, 150, 1e-4},
                                         Case{"wide_angle", 0.01, 1, 0.05, 0.95, 5, 2e-5},
                                         Case{"telephoto", 0.01, 1, 1e-6, 1e-4, 1e6, 2e-5}),
                         [](const auto& test) { return std::string(test.param.name); });

// A surface cut at random into splats as small as a pixel: what matters is the rays, not the boxes.
TEST(Splatter, CoversWhatItsSmallestSplatsContain) {
    const geom::View view = view_of(1280, 720, 1000);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    for (const float radius_px : {0.05f, 0.4f, 1.5f}) {
        std::vector<Splat> splats;
        for (int i = 0; i < 200000; ++i) {
            const float z = 1 + 9 * unit(random);
            const glm::vec3 ray(ray_of(view, 1280 * unit(random), 720 * unit(random)));
            splats.push_back(
                {z * ray, radius_px * z / 1000, random_unit(random), 0.01f + 0.99f * unit(random)});
        }
        const Frame frame = draw(view, {SplatKind::ellipse, {Shade::flat}}, splats, 7);
        std::vector<bool> inside(frame.depth.size()), touched(frame.depth.size());
        for (const Splat& s : splats) {
            const int cx = int(640 + 1000 * s.centre.x / s.centre.z),
                      cy = int(360 + 1000 * s.centre.y / s.centre.z);
            for (int y = std::max(0, cy - 3); y <= std::min(719, cy + 3); ++y) {
                for (int x = std::max(0, cx - 3); x <= std::min(1279, cx + 3); ++x) {
                    const double relative = pass(s, ray_of(view, x + 0.5, y + 0.5)).relative;
                    // A thousandth of a pixel, as a part of the thinnest splat's half thickness.
                    if (relative < 1 - 1e-4) inside[size_t(y * 1280 + x)] = true;
                    if (relative < 1 + 1e-4) touched[size_t(y * 1280 + x)] = true;
                }
            }
        }
        for (size_t i = 0; i < inside.size(); ++i) {
            if (inside[i]) {
                ASSERT_TRUE(std::isfinite(frame.depth[i])) << "hole at pixel " << i;
            } else if (!touched[i]) {
                ASSERT_FALSE(std::isfinite(frame.depth[i])) << "nothing covers pixel " << i;
            }
        }
    }
}

TEST(Splatter, CoversTheAreaOfADisc) {
    const geom::View view = view_of(640, 640, 800);
    for (const SplatKind kind : {SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        // A facing disc of 200 px; slanted by 60 degrees far away, half of that.
        const Splat facing{{0, 0, 10}, 2.5f, {0, 0, -1}, 0.01f};
        EXPECT_NEAR(double(covered(draw(view, {kind, {Shade::lit}}, {facing}))), 200.0 * 200.0 * M_PI, 500);
        if (kind == SplatKind::circle) continue;
        const geom::View far_view = view_of(640, 640, 8e4);
        const Splat slanted{{0, 0, 1000}, 2.5f, {0, std::sqrt(0.75f), -0.5f}, 0.01f};
        EXPECT_NEAR(double(covered(draw(far_view, {kind, {Shade::lit}}, {slanted}))), 200.0 * 100.0 * M_PI,
                    300);
    }
    EXPECT_EQ(covered(draw(view, {SplatKind::square, {Shade::lit}}, {{{0, 0, 10}, 2.5f, {0, 0, -1}, 1}})),
              400u * 400u);
}

TEST(Splatter, GivesAFacingDiscItsDepthAndColour) {
    const geom::View view = view_of(64, 48, 100);
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        const Frame frame = draw(view, {kind, {Shade::lit}}, {{{0, 0, 4}, 0.5f, {0, 0, -1}, 0.05f}});
        const size_t middle = size_t(24 * 64 + 32);
        EXPECT_NEAR(frame.depth[middle], 4, 1e-5);
        const glm::u8vec3 expected =
            render::shade_point(Shade::lit, {0, 0, -1}, glm::vec3(render::kGreyMaterial));
        EXPECT_EQ(frame.rgb[3 * middle], expected.r);
        EXPECT_EQ(frame.rgb[3 * middle + 1], expected.g);
        EXPECT_EQ(frame.rgb[0], 0);
        EXPECT_TRUE(std::isinf(frame.depth[0]));
    }
}

TEST(Splatter, ShadesAsOnePointDoes) {
    const geom::View view = view_of(16, 16, 20);
    std::mt19937 random(3);
    for (const Shade shade : {Shade::lit, Shade::normal, Shade::level, Shade::flat}) {
        for (const bool has_colour : {false, true}) {
            for (int i = 0; i < 200; ++i) {
                Splat s{{0, 0, 2}, 0.9f, random_unit(random), 0.5f};
                s.colour = uint32_t(random()) & 0xffffff;
                glm::vec3 material(render::kGreyMaterial);
                if (has_colour) material = {s.colour & 255, s.colour >> 8 & 255, s.colour >> 16 & 255};
                if (shade == Shade::level) material = render::level_colour(18.0f);
                const glm::u8vec3 expected = render::shade_point(shade, s.normal, material);
                for (const SplatKind kind : {SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
                    const Frame frame = draw(view, {kind, {shade}, has_colour}, {s});
                    const uint8_t* rgb = &frame.rgb[3 * (8 * 16 + 8)];
                    // Blending divides by the weight it multiplied with: a level is all that may be lost.
                    const int slack = kind == SplatKind::smooth ? 1 : 0;
                    for (int c = 0; c < 3; ++c)
                        ASSERT_NEAR(int(rgb[c]), int(expected[c]), slack) << int(shade) << i;
                }
            }
        }
    }
}

// Discs that overlap on a slanted plane through which nothing must show.
std::vector<Splat> tiled_plane(float rise) {
    std::vector<Splat> splats;
    const glm::vec3 normal = glm::normalize(glm::vec3(0.3f, rise, -1));
    for (int j = -180; j <= 180; ++j) {
        for (int i = -180; i <= 180; ++i) {
            const float x = 0.05f * float(i), y = 0.05f * float(j);
            splats.push_back({{x, y, 10 + 0.3f * x + rise * y}, 0.05f, normal, 0.02f});
        }
    }
    return splats;
}

// As of a wall that is as thin as the splats are wide: it is not glass.
TEST(Splatter, BlendsNoSheetWithOneThatLiesBehindIt) {
    const geom::View view = view_of(160, 120, 300);
    constexpr uint32_t kFront = 0x000000c0, kBehind = 0x0000c000;
    for (const float apart : {0.5f, 0.8f, 1.2f}) {
        std::vector<Splat> splats = tiled_plane(0.1f);
        const size_t count = splats.size();
        for (size_t i = 0; i < count; ++i) {
            Splat behind = splats[i];
            behind.centre -= apart * behind.radius * behind.normal;
            splats[i].colour = kFront, behind.colour = kBehind;
            splats.push_back(behind);
        }
        const Frame frame = draw(view, {SplatKind::smooth, {Shade::flat}, true}, splats, 7);
        for (size_t i = 0; i < frame.rgb.size(); i += 3) {
            ASSERT_EQ(int(frame.rgb[i]), 0xc0) << apart << ' ' << i;
            ASSERT_EQ(int(frame.rgb[i + 1]), 0) << apart << ' ' << i;
        }
    }
}

TEST(Splatter, ClosesAPlaneOfDiscs) {
    const geom::View view = view_of(320, 240, 300);
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth}) {
        const std::vector<Splat> splats = tiled_plane(0.5f);
        const Frame frame = draw(view, {kind, {Shade::lit}}, splats, 13);
        EXPECT_EQ(covered(frame), size_t(320 * 240));
        const glm::u8vec3 expected =
            render::shade_point(Shade::lit, splats[0].normal, glm::vec3(render::kGreyMaterial));
        for (int y = 0; y < 240; ++y) {
            for (int x = 0; x < 320; ++x) {
                const size_t i = size_t(y * 320 + x);
                const dvec3 ray = ray_of(view, x + 0.5, y + 0.5);
                const double depth = 10 / (1 - 0.3 * ray.x - 0.5 * ray.y);
                ASSERT_NEAR(frame.depth[i], depth, 2e-4);
                ASSERT_NEAR(int(frame.rgb[3 * i]), int(expected.r), kind == SplatKind::smooth ? 1 : 0);
            }
        }
    }
}

TEST(Splatter, HidesWhatLiesBehindByMoreThanARadius) {
    const geom::View view = view_of(320, 240, 300);
    std::vector<Splat> front = tiled_plane(0.0f), both;
    for (Splat& s : front) s.colour = 0x0000ff;
    for (const bool front_first : {true, false}) {
        both.clear();
        std::vector<Splat> back = front;
        for (Splat& s : back) s.centre.z += 0.06f, s.colour = 0xff0000;
        both.insert(both.end(), front_first ? front.begin() : back.begin(),
                    front_first ? front.end() : back.end());
        both.insert(both.end(), front_first ? back.begin() : front.begin(),
                    front_first ? back.end() : front.end());
        const Frame frame = draw(view, {SplatKind::smooth, {Shade::flat}, true}, both, 5);
        for (size_t i = 0; i < frame.depth.size(); ++i) {
            ASSERT_EQ(frame.rgb[3 * i], 255) << "pixel " << i;
            ASSERT_EQ(frame.rgb[3 * i + 2], 0) << "pixel " << i;
        }
    }
}

// A small splat within the radius of a large one, which is behind it and has its middle there: what counts
// for the colour counts for the depth.
TEST(Splatter, ShowsTheDepthOfTheSplatThatItShows) {
    const geom::View view = view_of(64, 64, 100);
    const Splat large{{0.015f, 0.015f, 3}, 1, {0, 0, -1}, 0.1f, 0xff0000},
        small{{0.0145f, 0.0125f, 2.5f}, 0.01f, {0, 0, -1}, 0.1f, 0x0000ff};
    for (const bool is_first : {true, false}) {
        const std::vector<Splat> splats = is_first ? std::vector{small, large} : std::vector{large, small};
        const Frame frame = draw(view, {SplatKind::smooth, {Shade::flat}, true}, splats);
        const size_t middle = 32 * 64 + 32;
        EXPECT_GT(frame.rgb[3 * middle], 245);
        EXPECT_NEAR(frame.depth[middle], 2.5, 1e-3) << (is_first ? "small first" : "large first");
    }
}

std::vector<Splat> random_scene(size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<Splat> splats;
    for (size_t i = 0; i < count; ++i) {
        Splat s{{4 * unit(random) - 2, 4 * unit(random) - 2, 1.5f + 6 * unit(random)},
                0.002f * std::pow(100.0f, unit(random)),
                random_unit(random),
                0.01f + 0.99f * unit(random)};
        if (i % 500 == 0)
            s = {{s.centre.x, s.centre.y, 0.1f}, 0.5f, s.normal, s.flatness};  // round the eye's plane
        s.colour = uint32_t(random()) & 0xffffff;
        splats.push_back(s);
    }
    return splats;
}

TEST(Splatter, EllipsesMayComeInAnyOrder) {
    const geom::View view = view_of(317, 211, 200);
    std::vector<Splat> splats = random_scene(20000, 11);
    const Frame first = draw(view, {SplatKind::ellipse, {Shade::lit}, true}, splats, 9);
    std::shuffle(splats.begin(), splats.end(), std::mt19937(1));
    const Frame second = draw(view, {SplatKind::ellipse, {Shade::lit}, true}, splats, 3);
    EXPECT_EQ(first.rgb, second.rgb);
    EXPECT_EQ(first.depth, second.depth);
}

TEST(Splatter, DrawsTheSameFrameWithAnyNumberOfThreads) {
    const geom::View view = view_of(317, 211, 200);
    const std::vector<Splat> splats = random_scene(20000, 12);
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        std::vector<Frame> frames;
        for (const int threads : {1, 2, 16}) {
            core::set_thread_count(threads);
            frames.push_back(draw(view, {kind, {Shade::lit}, true}, splats, 40));
        }
        core::set_thread_count(0);
        for (const Frame& frame : frames) {
            EXPECT_EQ(frame.rgb, frames[0].rgb);
            EXPECT_EQ(frame.depth, frames[0].depth);
        }
    }
}

// The frame of one splat with limits is the one without, less the pixels beyond them.
TEST(Splatter, DrawsOnlyBetweenNearAndFar) {
    std::mt19937 random(21);
    std::uniform_real_distribution<float> place(-1, 1), part(0, 1);
    constexpr double kRounding = 1e-6;
    size_t kept = 0, left_out = 0;
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        for (int round = 0; round < 60; ++round) {
            // Every third reaches behind the eye.
            const float z = round % 3 == 0 ? 0.5f : 3 + place(random);
            const std::vector<Splat> splat{
                {{place(random), place(random), z}, 1, random_unit(random), 0.05f + 0.95f * part(random)}};
            geom::View view = view_of(64, 48, 40);
            SplatterOptions options{kind, {Shade::normal}};
            options.look.background = {1, 2, 3};
            options.depth_unit = 1000;
            const Frame all = draw(view, options, splat);
            view.near = 1000.0 * std::max(0.01f, z - 0.5f * part(random));
            if (round % 2 == 0) view.far = *view.near + 200.0 * double(part(random));
            const Frame some = draw(view, options, splat);
            for (size_t i = 0; i < all.depth.size(); ++i) {
                const double depth = double(all.depth[i]), far = view.far.value_or(1e30);
                if (!std::isfinite(all.depth[i])) continue;
                if (std::abs(depth - *view.near) < kRounding * depth ||
                    std::abs(depth - far) < kRounding * depth)
                    continue;
                const bool is_shown = depth > *view.near && depth < far;
                (is_shown ? kept : left_out) += 1;
                ASSERT_EQ(some.depth[i], is_shown ? all.depth[i] : INFINITY) << "kind " << int(kind);
                for (size_t c = 3 * i; c < 3 * i + 3; ++c)
                    ASSERT_EQ(some.rgb[c], is_shown ? all.rgb[c] : c % 3 + 1) << "kind " << int(kind);
            }
        }
    }
    EXPECT_GT(kept, 10000u);
    EXPECT_GT(left_out, 10000u);
}

TEST(Splatter, ShowsWhatIsBehindWhatNearLeavesOut) {
    const Splat front{{0, 0, 2}, 0.5f, {0, 0, -1}, 0.1f, 0x000000ff},
        back{{0, 0, 4}, 1, {0, 0, -1}, 0.1f, 0x0000ff00};
    geom::View view = view_of(64, 48, 40);
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        const Frame alone = draw(view, {kind, {Shade::flat}, true}, {back});
        geom::View limited = view;
        limited.near = 3;
        EXPECT_EQ(draw(limited, {kind, {Shade::flat}, true}, {front, back}).rgb, alone.rgb);
        limited.near.reset(), limited.far = 3;
        EXPECT_EQ(draw(limited, {kind, {Shade::flat}, true}, {front, back}).rgb,
                  draw(view, {kind, {Shade::flat}, true}, {front}).rgb);
    }
}

TEST(Splatter, DrawsTheSameFrameWithAnyInstructionSet) {
    geom::View view = view_of(317, 211, 200);
    view.near = 1.5;
    const std::vector<Splat> splats = random_scene(5000, 13);
    for (const SplatKind kind : {SplatKind::square, SplatKind::ellipse, SplatKind::smooth}) {
        render::Look looks[3];
        looks[1].shade = Shade::normal;
        looks[2].samples_across = 2, looks[2].key_light = dvec3(1, 2, -1);
        for (const render::Look& look : looks) {
            Frame first;
            for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
                hwy::SetSupportedTargetsForTest(target);
                const Frame frame = draw(view, {kind, look, true}, splats, 10);
                hwy::SetSupportedTargetsForTest(0);
                if (first.width == 0) first = frame;
                EXPECT_EQ(frame.rgb, first.rgb) << hwy::TargetName(target);
                EXPECT_EQ(frame.depth, first.depth) << hwy::TargetName(target);
            }
        }
    }
}

// A frame's memory is the last frame's; nothing of it may show.
TEST(Splatter, ForgetsTheFrameBefore) {
    const geom::View view = view_of(317, 211, 200), small = view_of(65, 31, 40);
    Splatter splatter;
    Frame frame;
    draw(splatter, view, {SplatKind::smooth, {Shade::lit}, true}, random_scene(20000, 14), 30, frame);
    draw(splatter, small, {SplatKind::ellipse, {Shade::lit}}, random_scene(900, 15), 4, frame);
    const Frame fresh = draw(small, {SplatKind::ellipse, {Shade::lit}}, random_scene(900, 15), 4);
    EXPECT_EQ(frame.rgb, fresh.rgb);
    EXPECT_EQ(frame.depth, fresh.depth);
    draw(splatter, small, {SplatKind::ellipse, {Shade::lit, {1, 2, 3}}}, {}, 0, frame);
    EXPECT_EQ(covered(frame), 0u);
    EXPECT_EQ(frame.rgb[3 * 64 + 2], 3);
}

// All of the ellipsoid that is before the eye is covered, however it lies about the eye's plane.
TEST(Splatter, CoversSplatsThatReachBehindTheEye) {
    const geom::View view = view_of(120, 80, 60);
    std::mt19937 random(17);
    std::uniform_real_distribution<float> unit(0, 1);
    size_t drawn = 0;
    for (int round = 0; round < 500; ++round) {
        const float z = round % 7 == 0 ? 0.0f : 2 * unit(random) - 1;
        const Splat s{{3 * unit(random) - 1.5f, 3 * unit(random) - 1.5f, z},
                      0.2f + 2 * unit(random),
                      random_unit(random),
                      0.01f + 0.99f * unit(random)};
        for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth}) {
            const Frame frame = draw(view, {kind, {Shade::lit}}, {s});
            for (int y = 0; y < view.height; ++y) {
                for (int x = 0; x < view.width; ++x) {
                    const float depth = frame.depth[size_t(y * view.width + x)];
                    ASSERT_FALSE(std::isnan(depth));
                    const Passing at = pass(s, ray_of(view, x + 0.5, y + 0.5));
                    const bool eye_inside = pass(s, dvec3(s.centre) + dvec3(1e-9)).relative < 1 &&
                                            glm::length(dvec3(s.centre)) < s.radius * s.flatness;
                    if (eye_inside || (at.relative < 1 - 1e-4 && at.depth > 1e-4)) {
                        ASSERT_TRUE(std::isfinite(depth)) << x << "," << y << " round " << round;
                        ++drawn;
                    } else if (at.relative > 1 + 1e-3 && at.depth < -1) {
                        ASSERT_FALSE(std::isfinite(depth)) << x << "," << y << " round " << round;
                    }
                }
            }
        }
    }
    EXPECT_GT(drawn, 10000u);
}

TEST(Splatter, LeavesOutWhatIsBehindTheEye) {
    const geom::View view = view_of(120, 80, 60);
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        EXPECT_EQ(covered(draw(view, {kind, {Shade::lit}}, {{{0, 0, -2}, 1.0f, {0, 0, 1}, 1}})), 0u);
    }
}

TEST(Splatter, StandsAnyMagnitude) {
    const geom::View view = view_of(70, 50, 60);
    const float sizes[] = {1e-30f, 1e-20f, 1e-6f, 1, 1e6f, 1e20f, 1e30f};
    for (const SplatKind kind :
         {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth}) {
        for (const Shade shade : {Shade::lit, Shade::level}) {
            std::vector<Splat> splats;
            for (const float x : sizes) {
                for (const float z : sizes) {
                    for (const float radius : sizes) {
                        for (const float flatness : {1e-30f, 0.03f, 1.0f}) {
                            splats.push_back({{x, 0, z}, radius, {0, 0, -1}, flatness});
                            splats.push_back({{-x, x, -z}, radius, {1, 0, 0}, flatness});
                            splats.push_back({{0, -x, z}, radius, {0.6f, 0, -0.8f}, flatness});
                        }
                    }
                }
            }
            const Frame frame = draw(view, {kind, {shade}}, splats, 3);
            for (const float depth : frame.depth) {
                ASSERT_FALSE(std::isnan(depth));
                ASSERT_GE(depth, 0);
            }
            // And a disc alone, at any scale of the world, is the same picture.
            const Frame usual =
                draw(view, {kind, {shade}}, {{{0.5f, 0.25f, 2}, 0.5f, {0.6f, 0, -0.8f}, 0.03f}});
            for (const float scale : {0x1p-90f, 0x1p-40f, 0x1p40f, 0x1p90f}) {
                const Frame scaled =
                    draw(view, {kind, {shade}},
                         {{{0.5f * scale, 0.25f * scale, 2 * scale}, 0.5f * scale, {0.6f, 0, -0.8f}, 0.03f}});
                EXPECT_EQ(scaled.rgb, usual.rgb);
                EXPECT_EQ(covered(scaled), covered(usual));
            }
        }
    }
}

}  // namespace
