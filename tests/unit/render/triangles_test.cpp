// Triangles in the frames of the splatter: against the exact raster, without cracks, and beside splats.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>

#include "core/parallel.h"
#include "hybrid_scene.h"
#include "render/raster.h"
#include "render/splatter.h"

namespace {

using mesh::Mesh;
using render::Frame;
using render::Look;
using render::Shade;
using render::SplatKind;
using render::SplatterOptions;
using render_test::difference;
using render_test::Difference;
using render_test::Disc;
using render_test::draw;
using render_test::Scene;
using render_test::seen_from;
using render_test::Triangle;
using render_test::triangles_of;
using render_test::view_of;

constexpr SplatKind kKinds[] = {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth};

Frame reference(const Mesh& mesh, const geom::View& view, const Look& look = {}) {
    Frame frame;
    render::MeshRaster(mesh).draw(view, look, frame);
    return frame;
}

// The same pixels and depths.  Two surfaces at a pixel whose depths are the same in single precision may
// change places.
void expect_as_reference(const Mesh& mesh, const geom::View& view, const Look& look, size_t most_turned) {
    const Frame drawn =
        draw(view, {SplatKind::smooth, look, !mesh.colours.empty()}, {triangles_of(mesh), {}});
    const Difference d = difference(drawn, reference(mesh, view, look));
    EXPECT_EQ(d.covered_apart, 0u);
    EXPECT_LE(d.depth, 2e-6);
    EXPECT_LE(d.turned, most_turned);
}

TEST(Triangles, AreThoseOfTheExactRaster) {
    const Mesh rough = render_test::sheet(40, -1, -1, 0.05f, 2, 0.4f, 0.3f, 5);
    const Mesh ball = render_test::ball(5, {0.3f, -0.1f, 3}, 1);
    for (const Mesh* mesh : {&rough, &ball})
        for (const double focal_px : {20.0, 200.0, 1500.0, 40000.0})
            for (const Shade shade : {Shade::lit, Shade::normal, Shade::flat}) {
                SCOPED_TRACE(focal_px);
                expect_as_reference(*mesh, view_of(317, 211, focal_px), {shade, {10, 20, 30}}, 3);
            }
}

TEST(Triangles, AreThoseOfTheExactRasterFromWithinAMesh) {
    const Mesh ball = render_test::ball(3, {0, 0, 0}, 1);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 20; ++i) {
        SCOPED_TRACE(i);
        // Some as near to a face as a millionth of its size.
        const glm::dvec3 out = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
        const glm::dvec3 eye = (i % 2 ? 0.99 : 0.9) * out;
        const Mesh seen = seen_from(ball, eye, {unit(random), unit(random), unit(random)});
        expect_as_reference(seen, view_of(160, 120, i % 3 ? 60 : 9), {Shade::normal}, 3);
    }
}

TEST(Triangles, AreThoseOfTheExactRasterAtAnyMagnitude) {
    for (const double size : {1e-30, 1e-12, 1e12, 1e29}) {
        SCOPED_TRACE(size);
        Mesh mesh = render_test::sheet(12, -1, -1, 2.0f / 12, 2, 0.4f, 0.3f, 5);
        for (glm::vec3& p : mesh.positions) p = glm::vec3(glm::dvec3(p) * size);
        expect_as_reference(mesh, view_of(160, 120, 90), {Shade::lit}, 0);
    }
}

// Slivers, triangles of no area, of a millionth of a pixel and of a million screens, all at once.
TEST(Triangles, AreThoseOfTheExactRasterWhateverTheirForm) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int round = 0; round < 30; ++round) {
        SCOPED_TRACE(round);
        Mesh mesh;
        for (int i = 0; i < 60; ++i) {
            const auto point = [&](double spread) {
                const double z = std::exp(2 * normal(random)) * (i % 5 == 0 ? normal(random) : 1);
                return glm::dvec3(spread * z * normal(random), spread * z * normal(random), z);
            };
            const glm::dvec3 a = point(0.5), long_side = std::pow(10.0, 2 * normal(random)) * point(1);
            const double thickness = i % 4 == 0 ? 0 : std::pow(10.0, -3 + 3 * normal(random));
            const glm::dvec3 c = a + 0.4 * long_side + thickness * point(1);
            const uint32_t first = uint32_t(mesh.positions.size());
            for (const glm::dvec3& p : {a, a + long_side, c}) mesh.positions.push_back(glm::vec3(p));
            mesh.triangles.push_back({first, first + 1, first + 2});
            mesh.normals.insert(mesh.normals.end(), 3, glm::vec3(glm::normalize(point(1))));
        }
        const geom::View view = view_of(160, 120, 70);
        const Frame expected = reference(mesh, view);
        const Frame drawn = draw(view, {}, {triangles_of(mesh), {}});
        const Difference d = difference(drawn, expected);
        EXPECT_EQ(d.covered_apart, 0u);
        // Long needles differ by what their depths change within a rounding of single precision.
        EXPECT_LE(d.depth, 1e-4);
        EXPECT_LE(d.turned, 5u);
    }
}

// A pixel's centre belongs to one of the triangles about it and to no other.
TEST(Triangles, CoverEveryPixelOnce) {
    for (uint32_t seed = 0; seed < 12; ++seed) {
        SCOPED_TRACE(seed);
        const int cells = 3 + int(seed % 4);
        // Corners on pixel centres, on their edges, and anywhere.
        const float step = seed % 3 == 0 ? 8.0f : 7.3f;
        const float jitter = seed % 2 ? 0.24f : 0;  // every square stays convex
        const Mesh mesh = render_test::sheet(cells, -12 + 0.5f, -12 + 0.5f, step, 1, jitter, 0, seed);
        const geom::View view = view_of(64, 48, 1);
        const std::vector<Triangle> triangles = triangles_of(mesh);
        size_t sum = 0;
        for (const Triangle& t : triangles) sum += render_test::covered(draw(view, {}, {{t}, {}}));
        EXPECT_EQ(sum, render_test::covered(draw(view, {}, {triangles, {}})));
    }
}

// The screen is a thousandth of the view, about points on edges and corners of a closed mesh.
TEST(Triangles, LeaveNoCrackAtAnyZoom) {
    const Mesh ball = render_test::ball(4, {0, 0, 0}, 1);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 200; ++i) {
        const glm::u32vec3 t = ball.triangles[random() % ball.triangles.size()];
        const glm::dvec3 a = ball.positions[t[0]], b = ball.positions[t[1]];
        const glm::dvec3 target = i % 2 ? a : glm::mix(a, b, unit(random));
        const glm::dvec3 eye =
            3.0 * glm::normalize(target + 0.2 * glm::dvec3(unit(random), unit(random), unit(random)));
        const Mesh seen = seen_from(ball, eye, target - eye);
        const geom::View view = view_of(160, 120, 1000 * 90 * std::pow(10.0, unit(random)));
        const Frame frame = draw(view, {}, {triangles_of(seen), {}});
        ASSERT_EQ(render_test::covered(frame), frame.depth.size()) << i;
    }
}

// Both sides of triangles, about every shade and sampling.
TEST(Triangles, AreShadedAsTheExactRasterDoes) {
    Mesh mesh = render_test::sheet(9, -1, -1, 2.0f / 9, 2, 0.4f, 0.3f, 5);
    for (const bool is_turned : {false, true}) {
        if (is_turned)
            for (glm::u32vec3& t : mesh.triangles) std::swap(t[1], t[2]);
        for (const int across : {1, 2, 4})
            for (const Shade shade : {Shade::lit, Shade::normal, Shade::flat}) {
                SCOPED_TRACE(across);
                Look look{shade, {90, 80, 70}};
                look.samples_across = across;
                if (shade == Shade::lit) look.key_light = glm::dvec3(1, -2, -1);
                expect_as_reference(mesh, view_of(160, 120, 110), look, 0);
            }
    }
}

TEST(Triangles, HaveAColourEach) {
    Scene scene{triangles_of(render_test::sheet(6, -1, -1, 2.0f / 6, 2, 0.3f, 0, 5)), {}};
    std::mt19937 random(2);
    for (Triangle& t : scene.triangles) t.colour = random() & 0xffffffu;
    const geom::View view = view_of(96, 96, 90);
    const Frame all = draw(view, {SplatKind::smooth, {Shade::flat}, true}, scene);
    for (const Triangle& t : scene.triangles) {
        const Frame one = draw(view, {SplatKind::ellipse, {Shade::flat}, true}, {{t}, {}});
        for (size_t i = 0; i < one.depth.size(); ++i) {
            if (!std::isfinite(one.depth[i])) continue;
            EXPECT_EQ(one.rgb[3 * i] | one.rgb[3 * i + 1] << 8 | one.rgb[3 * i + 2] << 16, int(t.colour));
            for (size_t k = 3 * i; k < 3 * i + 3; ++k) EXPECT_EQ(all.rgb[k], one.rgb[k]);
        }
    }
    const Frame level = draw(view, {SplatKind::smooth, {Shade::level}, true}, scene);
    EXPECT_EQ(level.rgb[3 * (48 * 96 + 48) + 2], 160) << "the blue of the finest level";
}

TEST(Triangles, ObeyNearAndFar) {
    const Mesh ball = render_test::ball(4, {0, 0, 3}, 1);
    geom::View view = view_of(160, 120, 150);
    for (const auto& [near, far] : {std::pair{2.2, 2.9}, {1.0, 2.4}, {2.5, 9.0}}) {
        view.near = near, view.far = far;
        expect_as_reference(ball, view, {Shade::normal}, 3);
    }
}

// The eyes of a pair look through frustums off their axes, and depths are in the world's unit.
TEST(Triangles, AreThoseOfTheExactRasterInAnyFrustumAndUnit) {
    const Mesh ball = render_test::ball(4, {0, 0, 3}, 1);
    Mesh halved = ball;
    for (glm::vec3& p : halved.positions) p *= 0.5f;
    geom::View view = view_of(160, 120, 150);
    view.near = 2.2, view.far = 2.9;
    for (const glm::dvec2& shift_px : {glm::dvec2{37.3, -11.7}, {-900.1, 0.2}}) {
        view.shift_px = shift_px;
        SplatterOptions options;
        options.depth_unit = 2;
        const Difference d =
            difference(draw(view, options, {triangles_of(halved), {}}), reference(ball, view));
        EXPECT_LE(d.covered_apart, 2u) << "a depth within a rounding of a limit";
        EXPECT_LE(d.depth, 2e-6);
        EXPECT_LE(d.turned, 3u);
    }
}

Scene half_and_half(const Mesh& mesh, float cell) {
    return render_test::hybrid_of(mesh, [&](const glm::vec3& p) {
        return (int(std::floor(p.x / cell)) + int(std::floor(p.y / cell))) % 2 != 0;
    });
}

Scene test_scene(int ball_level = 5, int sheet_cells = 30) {
    Scene scene = half_and_half(render_test::ball(ball_level, {0.2f, 0.1f, 3}, 1), 0.25f);
    const float cell = 4.0f / float(sheet_cells);
    const Scene behind =
        half_and_half(render_test::sheet(sheet_cells, -2, -2, cell, 3.6f, 0.3f, 0.2f, 7), 0.4f);
    scene.triangles.insert(scene.triangles.end(), behind.triangles.begin(), behind.triangles.end());
    scene.discs.insert(scene.discs.end(), behind.discs.begin(), behind.discs.end());
    std::mt19937 random(2);
    for (Triangle& t : scene.triangles) t.colour = random() & 0xffffffu;
    for (Disc& d : scene.discs) d.colour = random() & 0xffffffu;
    return scene;
}

// Every kind, with and without limits and several samples.
template <class Body>
void for_options(const Body& body) {
    for (const SplatKind kind : kKinds)
        for (const Shade shade : {Shade::lit, Shade::level})
            for (const int across : {1, 2}) {
                SCOPED_TRACE(testing::Message()
                             << "kind " << int(kind) << " shade " << int(shade) << " across " << across);
                SplatterOptions options{kind, {shade}, true};
                options.look.samples_across = across;
                body(options);
            }
}

TEST(Triangles, MayComeInAnyBatchesAndTasksAndThreads) {
    // Small, so that it is run under the thread sanitizer too: some hundred triangles and discs on a dozen
    // tiles.
    const Scene scene = test_scene(3, 14);
    geom::View view = view_of(159, 106, 100);
    view.near = 2.05;
    struct Shares {
        size_t tasks;
        int batch_size, threads;
    };
    for_options([&](const SplatterOptions& options) {
        core::set_thread_count(1);
        const Frame expected = draw(view, options, scene, 1);
        for (const Shares& shares : {Shares{7, 33, 1}, Shares{2, 512, 5}, Shares{100, 7, 5}}) {
            core::set_thread_count(shares.threads);
            const Frame drawn = draw(view, options, scene, shares.tasks, shares.batch_size);
            EXPECT_EQ(drawn.rgb, expected.rgb);
            EXPECT_EQ(drawn.depth, expected.depth);
        }
        core::set_thread_count(0);
    });
}

TEST(Triangles, LookTheSameWithAnyInstructionSet) {
    const Scene scene = test_scene();
    const geom::View view = view_of(317, 211, 200);
    for_options([&](const SplatterOptions& options) {
        Frame first;
        for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
            hwy::SetSupportedTargetsForTest(target);
            const Frame frame = draw(view, options, scene);
            hwy::SetSupportedTargetsForTest(0);
            if (first.width == 0) first = frame;
            EXPECT_EQ(frame.rgb, first.rgb) << hwy::TargetName(target);
            EXPECT_EQ(frame.depth, first.depth) << hwy::TargetName(target);
        }
    });
}

TEST(Triangles, LookTheSameInPartsOfAPicture) {
    const Scene scene = test_scene();
    const geom::View view = view_of(317, 211, 200);
    for_options([&](const SplatterOptions& options) {
        const Frame whole = draw(view, options, scene);
        for (const glm::ivec4& part : {glm::ivec4{0, 0, 100, 211}, {101, 53, 147, 64}, {250, 190, 67, 21}}) {
            const Frame drawn = draw(geom::part_of(view, part.x, part.y, part.z, part.w), options, scene);
            for (int y = 0; y < part.w; ++y)
                for (int x = 0; x < part.z; ++x) {
                    const size_t at = size_t(y * part.z + x),
                                 in_whole = size_t((y + part.y) * 317 + x + part.x);
                    ASSERT_EQ(drawn.depth[at], whole.depth[in_whole]) << x << "," << y;
                    for (size_t k = 0; k < 3; ++k)
                        ASSERT_EQ(drawn.rgb[3 * at + k], whole.rgb[3 * in_whole + k]);
                }
        }
    });
}

TEST(Triangles, OfSeveralSamplesAreTheMeanOfALargerPicture) {
    const Scene scene{test_scene().triangles, {}};
    const geom::View view = view_of(160, 100, 110), large = geom::subdivided(view, 2);
    SplatterOptions options{SplatKind::smooth, {Shade::lit}, true};
    const Frame samples = draw(large, options, scene);
    options.look.samples_across = 2;
    const Frame drawn = draw(view, options, scene);
    for (size_t y = 0; y < 100; ++y)
        for (size_t x = 0; x < 160; ++x) {
            EXPECT_EQ(drawn.depth[y * 160 + x], samples.depth[(2 * y + 1) * 320 + 2 * x + 1]);
            for (size_t k = 0; k < 3; ++k) {
                int sum = 2;
                for (const size_t i : {0u, 1u, 320u, 321u})
                    sum += samples.rgb[3 * (2 * y * 320 + 2 * x + i) + k];
                EXPECT_EQ(drawn.rgb[3 * (y * 160 + x) + k], sum / 4);
            }
        }
}

// Wherever a disc lies over its own triangle the triangle shows, but where they are seen so nearly edge-on
// that a disc's thickness shows.
TEST(Triangles, ShowInFrontOfTheDiscsThatHoldThem) {
    std::mt19937 random(17);
    std::normal_distribution<float> normal;
    const geom::View view = view_of(120, 100, 120);
    for (int round = 0; round < 300; ++round) {
        // From a pixel to half a screen.
        const float size = std::exp(-2 + normal(random));
        Triangle t;
        for (glm::vec3& corner : t.corners)
            corner = glm::vec3(0, 0, 3) + size * glm::vec3(normal(random), normal(random), normal(random));
        for (glm::vec3& n : t.normals) n = {0, 0, -1};
        Disc disc = render_test::disc_of(t);
        t.colour = 0x00ff00, disc.colour = 0x0000ff;
        const float facing = std::abs(glm::dot(disc.normal, glm::normalize(disc.centre)));
        if (disc.radius > 1 || facing < 4 * disc.flatness) continue;
        for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth}) {
            const SplatterOptions options{kind, {Shade::flat}, true};
            const Frame alone = draw(view, options, {{t}, {}}), both = draw(view, options, {{t}, {disc}});
            size_t hidden = 0, outside = 0;
            for (size_t i = 0; i < alone.depth.size(); ++i) {
                if (std::isfinite(alone.depth[i]))
                    hidden += both.depth[i] != alone.depth[i];
                else
                    outside += both.rgb[3 * i] == 255;
            }
            EXPECT_EQ(hidden, 0u) << round;
            EXPECT_TRUE(outside > 0 || disc.radius < 0.1f) << round;
        }
    }
}

// The push is against triangles, by as much as is asked for.
TEST(Triangles, PushSplatsBackByPixelsOfDepth) {
    const geom::View view = view_of(64, 64, 100);
    for (const SplatKind kind : kKinds)
        for (const double push_back_px : {2.0, 7.0}) {
            const float disc_z = 2, most = disc_z * float(1 + push_back_px / 100);
            for (const float z : {0.999f * most, 1.001f * most}) {
                Scene scene;
                scene.triangles.push_back(
                    {{{-9, -9, z}, {9, -9, z}, {0, 9, z}}, {{0, 0, -1}, {0, 0, -1}, {0, 0, -1}}, 0x00ff00});
                scene.discs.push_back({{0, 0, disc_z}, 0.5f, {0, 0, -1}, 0.01f, 0x0000ff});
                SplatterOptions options{kind, {Shade::flat}, true};
                options.push_back_px = push_back_px;
                const Frame frame = draw(view, options, scene);
                const size_t middle = 32 * 64 + 32;
                EXPECT_EQ(frame.rgb[3 * middle] == 255, z > most);
                EXPECT_EQ(frame.depth[middle], z > most ? disc_z : z);
                EXPECT_EQ(frame.depth[0], z);
            }
        }
}

// No hole where triangles meet splats, and nothing of what lies behind.
TEST(Triangles, JoinSplatsWithoutAHole) {
    const Mesh front = render_test::sheet(64, -1.6f, -1.6f, 0.05f, 3, 0.4f, 0.01f, 3);
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth})
        for (const double focal_px : {50.0, 300.0, 3000.0})
            for (const bool has_back : {false, true}) {
                Scene scene = half_and_half(front, 0.11f);
                for (Triangle& t : scene.triangles) t.colour = 0xff0000;
                for (Disc& d : scene.discs) d.colour = 0xff0000;
                // Nearer than which nothing may show through: three pixels, or what a disc reaches.
                const float z = 3.02f + float(std::max(3 * 3 / focal_px, 0.02));
                scene.triangles.push_back({{{-90, -90, z}, {90, -90, z}, {0, 90, z}},
                                           {{0, 0, -1}, {0, 0, -1}, {0, 0, -1}},
                                           0x00ff});
                SplatterOptions options{kind, {Shade::flat}, true};
                options.look.samples_across = has_back ? 1 : 2;
                const int size = std::min(200, int(focal_px));
                const Frame frame = draw(view_of(size, size, focal_px), options, scene);
                size_t missing = 0;
                for (size_t i = 0; i < frame.depth.size(); ++i) missing += frame.rgb[3 * i + 2] != 255;
                EXPECT_EQ(has_back ? missing : frame.depth.size() - render_test::covered(frame), 0u)
                    << "focal " << focal_px << " back " << has_back << " kind " << int(kind);
            }
}

// What a map takes for hidden, of a surface of triangles and discs with holes and of what floats behind and
// about it.
struct Hiding {
    geom::OcclusionMap map;
    Scene front, loose;

    explicit Hiding(uint32_t seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> unit(-1, 1);
        front = half_and_half(render_test::sheet(40, -2, -2, 0.1f, 3, 0.3f, 0.02f, seed), 0.7f);
        // Holes of some triangles or discs.
        const auto thin = [&](auto& items) {
            std::erase_if(items, [&](const auto&) { return unit(random) > 0.995f; });
        };
        thin(front.triangles), thin(front.discs);
        for (int i = 0; i < 3000; ++i) {
            // Most behind, some just behind, some before.
            const float z = 3 + (i % 4 == 0 ? 0.3f * unit(random) : i % 4 == 1 ? 0.5f : 1 + unit(random));
            const glm::vec3 middle(unit(random) * 0.6f * z, unit(random) * 0.45f * z, z);
            const auto vary = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
            const glm::vec3 n = glm::normalize(vary() - glm::vec3(0, 0, 2));
            const uint32_t colour = random() & 0xffffffu;
            if (i % 50 == 0)  // blends with the surface from behind, across what is hidden
                loose.discs.push_back(
                    {{middle.x, middle.y, 3.25f + 0.1f * unit(random)}, 0.4f, n, 0.1f, colour});
            else if (i % 2)
                loose.discs.push_back({middle, 0.08f * (1.2f + unit(random)), n, 0.1f, colour});
            else
                loose.triangles.push_back(
                    {{middle + 0.06f * vary(), middle + 0.06f * vary(), middle + 0.06f * vary()},
                     {n, n, n},
                     colour});
        }
    }

    void begin(const geom::View& view) {
        map.begin(view, 1);
        std::vector<geom::OcclusionMap::Surface> surfaces;
        for (const Disc& d : front.discs) surfaces.push_back({d.centre, d.radius, d.normal, 0.01f});
        for (const Triangle& t : front.triangles) {
            const Disc d = render_test::disc_of(t);
            surfaces.push_back({d.centre, d.radius, d.normal, 0.01f});
        }
        map.add_surfaces(surfaces);
        map.build();
    }

    // All but what is hidden.
    Scene seen() {
        Scene scene = front;
        const auto is_seen = [&](const glm::vec3& centre, float radius) {
            geom::OcclusionMap::Spheres sphere;
            geom::OcclusionMap::Sight sight;
            sphere.add(centre, radius);
            map.look(sphere, &sight);
            return sight != geom::OcclusionMap::Sight::hidden;
        };
        for (const Disc& d : loose.discs)
            if (is_seen(d.centre, d.radius)) scene.discs.push_back(d);
        for (const Triangle& t : loose.triangles) {
            const glm::vec3 centre = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f;
            float radius = 0;
            for (const glm::vec3& corner : t.corners)
                radius = std::max(radius, 1.001f * glm::distance(corner, centre));
            if (is_seen(centre, radius)) scene.triangles.push_back(t);
        }
        return scene;
    }

    Scene all() const {
        Scene scene = front;
        scene.discs.insert(scene.discs.end(), loose.discs.begin(), loose.discs.end());
        scene.triangles.insert(scene.triangles.end(), loose.triangles.begin(), loose.triangles.end());
        return scene;
    }
};

TEST(Triangles, HideAndAreHiddenWithoutATrace) {
    size_t left_out = 0, proved = 0, repeated = 0;
    for (const uint32_t seed : {1u, 2u, 3u})
        for (const SplatKind kind : kKinds)
            for (const double push_back_px : {2.0, 30.0}) {
                SCOPED_TRACE(testing::Message() << "seed " << seed << " kind " << int(kind));
                const geom::View view = view_of(400, 300, 320);
                SplatterOptions options{kind, {Shade::lit}, true};
                options.push_back_px = push_back_px, options.has_triangles = true;
                Hiding hiding(seed);
                const Frame expected = draw(view, options, hiding.all());
                hiding.begin(view);
                render::Splatter splatter;
                Frame frame;
                const Scene seen = hiding.seen();
                left_out += hiding.all().discs.size() - seen.discs.size();
                left_out += hiding.all().triangles.size() - seen.triangles.size();
                render_test::add(splatter, view, options, seen);
                splatter.finish(frame, hiding.map);
                for (int y = 8; y < view.height; y += 16)
                    for (int x = 8; x < view.width; x += 16)
                        if (hiding.map.limit(x, y) > 0) ++(hiding.map.is_unproven(x, y) ? repeated : proved);
                if (hiding.map.has_unproven()) {
                    hiding.map.begin_repeat();
                    render_test::add(splatter, view, options, hiding.seen());
                    splatter.finish(frame, hiding.map);
                }
                EXPECT_EQ(frame.rgb, expected.rgb);
                EXPECT_EQ(frame.depth, expected.depth);
            }
    EXPECT_GT(left_out, 5000u);
    EXPECT_GT(proved, 2000u);
    EXPECT_GT(repeated, 500u);
}

TEST(Triangles, AreForgottenByTheNextFrame) {
    const Scene scene = test_scene();
    render::Splatter splatter;
    const SplatterOptions options{SplatKind::smooth, {Shade::lit}, true};
    draw(splatter, view_of(317, 211, 200), options, scene, 30);
    const Scene few{{scene.triangles.begin(), scene.triangles.begin() + 50}, {}};
    const geom::View small = view_of(65, 31, 40);
    const Frame again = draw(splatter, small, options, few, 4), fresh = draw(small, options, few, 4);
    EXPECT_EQ(again.rgb, fresh.rgb);
    EXPECT_EQ(again.depth, fresh.depth);
    EXPECT_EQ(render_test::covered(draw(splatter, small, options, {}, 4)), 0u);
}

}  // namespace
