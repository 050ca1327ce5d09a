#include "render/raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "core/parallel.h"
#include "hybrid_scene.h"
#include "mesh/distance.h"

namespace {

using geom::View;
using mesh::Mesh;
using render::Frame;
using render::Shade;
using render_test::icosphere;

View axis_view(int width, int height, double focal_px) {
    View view;
    view.width = width, view.height = height, view.focal_px = focal_px;
    return view;
}

Frame draw(const Mesh& mesh, const View& view, Shade shade = Shade::lit, glm::u8vec3 background = {1, 2, 3}) {
    Frame frame;
    render::MeshRaster(mesh).draw(view, {shade, background}, frame);
    return frame;
}

bool covered(const Frame& frame, int x, int y) {
    return std::isfinite(frame.depth[size_t(y) * size_t(frame.width) + size_t(x)]);
}

float depth(const Frame& frame, int x, int y) {
    return frame.depth[size_t(y) * size_t(frame.width) + size_t(x)];
}

int count_covered(const Frame& frame) {
    int count = 0;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) count += covered(frame, x, y);
    return count;
}

// Distance from the middle to the nearest face of a polyhedron around it.
double inner_radius(const Mesh& mesh) {
    double least = 1;
    for (const glm::u32vec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        least = std::min(least, std::abs(glm::dot(glm::normalize(glm::cross(b - a, c - a)), a)));
    }
    return least;
}

// A grid of `cells` x `cells` squares, two triangles each, at depth `z`, corners every `step` from (x0, y0),
// inner vertices moved by up to `jitter` in all directions.
Mesh grid(int cells, float x0, float y0, float step, float z, float jitter, uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> move(-jitter, jitter);
    Mesh mesh;
    const uint32_t row = uint32_t(cells) + 1;
    for (uint32_t j = 0; j < row; ++j)
        for (uint32_t i = 0; i < row; ++i)
            mesh.positions.push_back(
                {x0 + step * float(i) + move(random), y0 + step * float(j) + move(random), z + move(random)});
    for (uint32_t j = 0; j + 1 < row; ++j)
        for (uint32_t i = 0; i + 1 < row; ++i) {
            const uint32_t at = j * row + i;
            mesh.triangles.push_back({at, at + 1, at + row});
            mesh.triangles.push_back({at + row + 1, at + row, at + 1});
        }
    return mesh;
}

struct Hit {
    bool covered;
    double depth;
};

// What an integer triangle covers at the centre of pixel (x, y) of axis_view(width, height, 0.5), in exact
// arithmetic; a ray on an edge is decided by moving it by 2^-24 pixel right and 2^-48 down.
Hit exact_hit(const glm::i64vec3 (&p)[3], int width, int height, int x, int y) {
    using Wide = __int128;
    const Wide fine = Wide(1) << 24;
    const Wide ray[3] = {(2 * x + 1 - width) * fine * fine + fine, (2 * y + 1 - height) * fine * fine + 1,
                         fine * fine};
    Wide side[3], det = 0;
    for (int i = 0; i < 3; ++i) {
        const glm::i64vec3 &a = p[(i + 1) % 3], &b = p[(i + 2) % 3];
        const glm::i64vec3 c{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
        side[i] = c.x * ray[0] + c.y * ray[1] + c.z * ray[2];
        det = c.x * p[i].x + c.y * p[i].y + c.z * p[i].z;
    }
    const bool front = det > 0 && side[0] > 0 && side[1] > 0 && side[2] > 0;
    const bool back = det < 0 && side[0] < 0 && side[1] < 0 && side[2] < 0;
    if (!front && !back) return {false, 0};
    return {true, double(det) / (double(side[0] + side[1] + side[2]) / double(fine * fine))};
}

TEST(MeshRaster, DrawsOnlyBetweenNearAndFar) {
    Mesh mesh = icosphere(3);
    mesh.origin = {0, 0, 3};
    View view = axis_view(64, 48, 60);
    const Frame all = draw(mesh, view);
    view.far = 2.3;
    const Frame before = draw(mesh, view);
    view.far.reset(), view.near = 2.3;
    const Frame behind = draw(mesh, view);
    int cut = 0, seen_behind = 0;
    for (size_t i = 0; i < all.depth.size(); ++i) {
        const bool is_before = all.depth[i] <= 2.3f;
        EXPECT_EQ(before.depth[i], is_before ? all.depth[i] : INFINITY);
        EXPECT_GE(behind.depth[i], is_before ? 2.3f : all.depth[i]);
        if (!is_before) {
            EXPECT_EQ(behind.depth[i], all.depth[i]);
        }
        cut += is_before;
        seen_behind += is_before && std::isfinite(behind.depth[i]);
    }
    EXPECT_GT(cut, 200);
    EXPECT_EQ(seen_behind, cut) << "the far side of the sphere shows through the hole";
}

TEST(MeshRaster, CoversExactlyTheCentresInsideATriangle) {
    const int width = 40, height = 30;
    const View view = axis_view(width, height, 0.5);
    std::mt19937 random(7);
    std::uniform_int_distribution<int> across(-60, 60), near(1, 3), any(-9, 9);
    int total = 0;
    for (int round = 0; round < 3000; ++round) {
        glm::i64vec3 p[3];
        Mesh mesh;
        for (glm::i64vec3& v : p) {
            v = {across(random), across(random), round % 2 ? near(random) : any(random)};
            mesh.positions.push_back(glm::vec3(v));
        }
        mesh.triangles = {{0, 1, 2}};
        const Frame frame = draw(mesh, view);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const Hit hit = exact_hit(p, width, height, x, y);
                ASSERT_EQ(covered(frame, x, y), hit.covered)
                    << "round " << round << " pixel " << x << "," << y;
                if (!hit.covered) continue;
                ++total;
                ASSERT_NEAR(depth(frame, x, y), hit.depth, 1e-5 * hit.depth) << "round " << round;
            }
    }
    EXPECT_GT(total, 100000);
}

// Draws every triangle alone and counts how many cover each pixel.
std::vector<int> cover_counts(const Mesh& mesh, const View& view) {
    std::vector<int> counts(size_t(view.width) * size_t(view.height), 0);
    Mesh one = mesh;
    for (const glm::u32vec3& t : mesh.triangles) {
        one.triangles = {t};
        const Frame frame = draw(one, view);
        for (size_t i = 0; i < counts.size(); ++i) counts[i] += std::isfinite(frame.depth[i]);
    }
    return counts;
}

TEST(MeshRaster, CoversEachPixelOfATessellatedPlaneOnce) {
    const View view = axis_view(70, 66, 32);
    // Corners on pixel centres, on pixel corners, between them, and moved about in depth too.
    const Mesh meshes[] = {grid(10, -39.5f, -39.5f, 8, 32, 0, 1), grid(10, -40, -40, 8, 32, 0, 1),
                           grid(14, -7, -7, 1, 4.7f, 0.1f, 2), grid(20, -50.1f, -50.3f, 5, 32, 0.7f, 3)};
    for (const Mesh& mesh : meshes)
        for (const int count : cover_counts(mesh, view)) ASSERT_EQ(count, 1);
}

TEST(MeshRaster, CoversEachPixelOnceFarFromTheOrigin) {
    View view = axis_view(70, 66, 32);
    Mesh mesh = grid(10, -50.1f, -50.3f, 10, 32, 1.5f, 4);
    for (const double offset : {1e7, 1e12}) {
        mesh.origin = view.eye = glm::dvec3(offset, -offset, 0.5 * offset);
        for (const int count : cover_counts(mesh, view)) ASSERT_EQ(count, 1) << offset;
    }
}

// A square of 10 pixels, with its left and top edge at `corner` pixels in both directions.
void expect_pixels_ten_to_twenty(float corner) {
    const View view = axis_view(64, 48, 16);
    const Frame frame = draw(grid(1, corner - 32, corner - 24, 10, 16, 0, 1), view);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            ASSERT_EQ(covered(frame, x, y), x >= 10 && x < 20 && y >= 10 && y < 20) << x << "," << y;
}

TEST(MeshRaster, ASquareFromPixelTenToTwentyCoversThosePixels) {
    expect_pixels_ten_to_twenty(10);
}

TEST(MeshRaster, SamplesOnTheLeftAndTopEdgesAreInAndOthersOut) {
    expect_pixels_ten_to_twenty(10.5f);  // corners on pixel centres
}

TEST(MeshRaster, BothSidesAreDrawn) {
    const View view = axis_view(64, 48, 40);
    Mesh mesh = icosphere(2);
    mesh.origin = {0.1, 0.2, 4};
    const Frame frame = draw(mesh, view, Shade::flat);
    for (glm::u32vec3& t : mesh.triangles) std::swap(t[0], t[1]);
    const Frame turned = draw(mesh, view, Shade::flat);
    EXPECT_EQ(frame.depth, turned.depth);
    EXPECT_EQ(frame.rgb, turned.rgb);
    EXPECT_GT(count_covered(frame), 200);
}

// Depths along the ray through a pixel centre where it enters the sphere; nothing where it misses.
std::optional<double> sphere_depth(const View& view, const glm::dvec3& centre, double radius, int x, int y,
                                   bool leaving) {
    const glm::dvec3 ray{(x + 0.5 - view.width / 2.0) / view.focal_px,
                         (y + 0.5 - view.height / 2.0) / view.focal_px, 1};
    const glm::dvec3 c = view.view_from_world(centre);
    const double half = glm::dot(ray, c) / glm::dot(ray, ray);
    const glm::dvec3 off = c - half * ray;  // perpendicular to the ray: no cancellation at long range
    const double inside = radius * radius - glm::dot(off, off);
    if (inside < 0) return std::nullopt;
    return half + (leaving ? 1 : -1) * std::sqrt(inside / glm::dot(ray, ray));
}

// A polyhedron between two spheres: every ray that meets the inner must be covered, none that misses the
// outer, and depths lie between the two.
void check_between_spheres(const Mesh& mesh, const View& view, double inner, const std::string& name) {
    const Frame frame = draw(mesh, view);
    const double outer = 1 + 1e-6, slack = 1e-6;
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const auto enter = sphere_depth(view, mesh.origin, outer, x, y, false);
            const auto solid = sphere_depth(view, mesh.origin, inner - slack, x, y, false);
            if (solid && *solid > 0) {
                ASSERT_TRUE(covered(frame, x, y)) << name << " hole at " << x << "," << y;
                ASSERT_LE(depth(frame, x, y), *solid * (1 + slack)) << name;
            }
            ASSERT_TRUE(enter || !covered(frame, x, y)) << name << " grew at " << x << "," << y;
            if (enter) {
                ASSERT_GE(depth(frame, x, y), *enter * (1 - slack)) << name;
            }
        }
}

TEST(MeshRaster, ClosedMeshesHaveNoHolesFromAnyCamera) {
    const Mesh sphere = icosphere(4);
    const double inner = inner_radius(sphere);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (const double distance : {1.01, 1.5, 3.0, 100.0, 1e6}) {
        for (int round = 0; round < 4; ++round) {
            const glm::dvec3 eye =
                distance * glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
            geom::Camera camera;
            camera.eye = eye, camera.fovy_deg = distance > 1e5 ? 0.001
                                                : distance < 2 ? 120
                                                               : 2.2 / distance * 57;
            check_between_spheres(sphere, geom::make_view(camera, 97, 75), inner, std::to_string(distance));
        }
    }
}

TEST(MeshRaster, ACameraInsideSeesTheMeshAllRound) {
    Mesh sphere = icosphere(3);
    sphere.origin = {1e7, 2e7, -3e6};
    const double inner = inner_radius(sphere);
    for (const double fovy : {0.001, 30.0, 90.0, 179.0}) {
        for (const glm::dvec3& place : {glm::dvec3(0), glm::dvec3(0.3, 0.5, -0.1), glm::dvec3(0, 0, 0.99)}) {
            for (const glm::dvec3& way :
                 {glm::dvec3(1, 0.1, 0.2), glm::dvec3(0, 0, -1), glm::dvec3(-1, 3, 2)}) {
                geom::Camera camera;
                camera.eye = sphere.origin + place, camera.target = camera.eye + way, camera.fovy_deg = fovy;
                const View view = geom::make_view(camera, 80, 60);
                const Frame frame = draw(sphere, view);
                for (int y = 0; y < view.height; ++y)
                    for (int x = 0; x < view.width; ++x) {
                        ASSERT_TRUE(covered(frame, x, y)) << fovy << " at " << x << "," << y;
                        const double most = *sphere_depth(view, sphere.origin, 1 + 1e-6, x, y, true);
                        ASSERT_LE(depth(frame, x, y), most * (1 + 1e-6));
                        const auto least = sphere_depth(view, sphere.origin, inner - 1e-6, x, y, true);
                        if (least) {
                            ASSERT_GE(depth(frame, x, y), *least * (1 - 1e-6));
                        }
                    }
            }
        }
    }
}

TEST(MeshRaster, AVertexOrAFaceAtTheEyeDoesNoHarm) {
    Mesh sphere = icosphere(2);
    geom::Camera camera;
    const glm::u32vec3 t = sphere.triangles[5];
    const glm::vec3 middle =
        (sphere.positions[t[0]] + sphere.positions[t[1]] + sphere.positions[t[2]]) / 3.0f;
    for (const glm::vec3& eye :
         {sphere.positions[t[0]], (sphere.positions[t[0]] + sphere.positions[t[1]]) / 2.0f, middle}) {
        camera.eye = eye;
        for (const double fovy : {0.001, 60.0, 179.0}) {
            camera.fovy_deg = fovy;
            const Frame frame = draw(sphere, geom::make_view(camera, 64, 64));
            // Whatever is seen is on the sphere; only sideways can a ray miss it.
            for (const float z : frame.depth) {
                ASSERT_GE(z, 0) << fovy;
                ASSERT_TRUE(z <= 2.001f || (fovy == 179 && std::isinf(z))) << fovy << " " << z;
            }
        }
    }
}

TEST(MeshRaster, DepthIsThatOfThePlane) {
    geom::Camera camera;
    camera.eye = {0.3, 0.4, 2}, camera.target = {0.2, 0, 0}, camera.fovy_deg = 100;
    const View view = geom::make_view(camera, 120, 90);
    const Mesh floor =
        grid(1, -1000, -1000, 2000, 0, 0, 1);  // z = 0, far larger than the view, behind the eye too
    const Frame frame = draw(floor, view);
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const glm::dvec3 ray =
                view.forward + ((x + 0.5 - 60) * view.right + (y + 0.5 - 45) * view.down) / view.focal_px;
            const double z = -view.eye.z / ray.z;
            if (z > 0 && z < 400) {
                ASSERT_NEAR(depth(frame, x, y), z, 1e-6 * z) << x << "," << y;
            }
        }
    EXPECT_GT(count_covered(frame), 120 * 45);
}

TEST(MeshRaster, EveryDrawnPointLiesOnTheMesh) {
    Mesh mesh = icosphere(4);
    for (glm::vec3& p : mesh.positions) p *= 1 + 0.3f * std::sin(9 * p.x) * std::cos(7 * p.y);
    const mesh::SurfaceDistance surface(mesh);
    for (const glm::dvec3& eye : {glm::dvec3(3, 1, 2), glm::dvec3(0.2, 0.1, 0), glm::dvec3(-1.4, 0, 0.1)}) {
        geom::Camera camera;
        camera.eye = eye, camera.target = {0.1, -0.3, 0.2}, camera.fovy_deg = 70;
        const View view = geom::make_view(camera, 120, 100);
        const Frame frame = draw(mesh, view);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                if (!covered(frame, x, y)) continue;
                const double z = depth(frame, x, y);
                const glm::dvec3 point =
                    view.eye +
                    z * (view.forward +
                         ((x + 0.5 - 60) * view.right + (y + 0.5 - 50) * view.down) / view.focal_px);
                ASSERT_LE(surface.distance(point, 1), 2e-7 * z) << x << "," << y;
            }
        EXPECT_GT(count_covered(frame), 1000);
    }
}

TEST(MeshRaster, AFlatGroundReachesTheHorizon) {
    geom::Camera camera;
    camera.eye = {0, 0, 1e-3}, camera.target = {1, 0, 1e-3}, camera.up = {0, 0, 1}, camera.fovy_deg = 60;
    const View view = geom::make_view(camera, 64, 64);
    const Frame frame = draw(grid(8, -1e6f, -1e6f, 2.5e5f, 0, 0, 1), view);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) ASSERT_EQ(covered(frame, x, y), y >= 32) << x << "," << y;
}

TEST(MeshRaster, ScaleChangesDepthsOnly) {
    Mesh mesh = icosphere(3);
    for (glm::vec3& p : mesh.positions) p += glm::vec3(0.25f, 0.125f, 3);
    const View view = axis_view(90, 70, 80);
    const Frame frame = draw(mesh, view);
    for (const int power : {-120, -100, 100, 120}) {
        Mesh scaled = mesh;
        for (glm::vec3& p : scaled.positions)
            p = {std::ldexp(p.x, power), std::ldexp(p.y, power), std::ldexp(p.z, power)};
        const Frame other = draw(scaled, view);
        EXPECT_EQ(other.rgb, frame.rgb) << power;
        for (size_t i = 0; i < frame.depth.size(); ++i)
            ASSERT_EQ(other.depth[i], std::ldexp(frame.depth[i], power));
    }
}

TEST(MeshRaster, AnExactOffsetChangesNothing) {
    Mesh mesh = icosphere(3);
    for (glm::vec3& p : mesh.positions) p = glm::round(p * 0x1p20f) * 0x1p-20f;
    View view = axis_view(90, 70, 80);
    view.eye = {0.25, 0.125, -3};
    const Frame frame = draw(mesh, view);
    const glm::dvec3 offset{1e7, -2e7, 3e7};
    mesh.origin += offset, view.eye += offset;
    const Frame other = draw(mesh, view);
    EXPECT_EQ(other.rgb, frame.rgb);
    EXPECT_EQ(other.depth, frame.depth);
}

TEST(MeshRaster, DegenerateTrianglesCoverNothing) {
    Mesh mesh;
    mesh.positions = {{-2, -2, 5}, {0, 0, 5}, {2, 2, 5}, {-2, 1, -5}, {-2, 1, 5}};
    mesh.triangles = {{0, 1, 2}, {0, 0, 1}, {1, 1, 1}, {0, 2, 0}, {3, 4, 3}};
    const Frame frame = draw(mesh, axis_view(63, 63, 100));  // odd: a centre lies on the segments
    EXPECT_EQ(count_covered(frame), 0);
    EXPECT_EQ(frame.rgb[0], 1);
    EXPECT_EQ(frame.rgb[1], 2);
    EXPECT_EQ(frame.rgb[2], 3);
}

TEST(MeshRaster, ACloudOrAnEmptyMeshDrawsNothing) {
    Mesh mesh;
    EXPECT_EQ(count_covered(draw(mesh, axis_view(30, 20, 10))), 0);
    mesh.positions = {{0, 0, 1}};
    EXPECT_EQ(count_covered(draw(mesh, axis_view(30, 20, 10))), 0);
}

TEST(MeshRaster, TheNearerSurfaceShows) {
    Mesh mesh = grid(1, -10, -10, 20, 8, 0, 1);
    const Mesh front = grid(1, -1, -1, 2, 4, 0, 1);
    for (const glm::u32vec3& t : front.triangles)
        mesh.triangles.push_back(t + uint32_t(mesh.positions.size()));
    mesh.positions.insert(mesh.positions.end(), front.positions.begin(), front.positions.end());
    const View view = axis_view(64, 64, 32);
    for (int round = 0; round < 2; ++round) {
        const Frame frame = draw(mesh, view);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                ASSERT_EQ(depth(frame, x, y), x >= 24 && x < 40 && y >= 24 && y < 40 ? 4 : 8);
        std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    }
}

TEST(MeshRaster, ColoursAreInterpolatedInSpaceNotOnTheScreen) {
    // A square turned about the vertical axis: at the middle of the screen it is not half way across.
    Mesh mesh;
    mesh.positions = {{-2, -2, 2}, {2, -2, 6}, {-2, 2, 2}, {2, 2, 6}};
    mesh.colours = {{0, 0, 10}, {240, 0, 10}, {0, 120, 10}, {240, 120, 10}};
    mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
    const View view = axis_view(101, 81, 40);
    const Frame frame = draw(mesh, view, Shade::flat);
    int tested = 0;
    for (int y = 0; y < 81; ++y)
        for (int x = 0; x < 101; ++x) {
            if (!covered(frame, x, y)) continue;
            const double z = depth(frame, x, y);
            const double s = ((x - 50) * z / 40 + 2) / 4, t = ((y - 40) * z / 40 + 2) / 4;
            const uint8_t* rgb = &frame.rgb[3 * (size_t(y) * 101 + size_t(x))];
            ASSERT_NEAR(rgb[0], 240 * s, 1) << x << "," << y;
            ASSERT_NEAR(rgb[1], 120 * t, 1) << x << "," << y;
            ASSERT_EQ(rgb[2], 10);
            ++tested;
        }
    EXPECT_GT(tested, 1000);
}

TEST(MeshRaster, LightFollowsTheInterpolatedNormal) {
    Mesh mesh = grid(1, -4, -4, 8, 4, 0, 1);
    const View view = axis_view(32, 32, 16);
    const auto grey = [&] { return int(draw(mesh, view).rgb[3 * (16 * 32 + 16)]); };
    const auto lit = [](double cosine) { return 255 * 0.9 * (0.05 + 0.95 * cosine); };
    mesh.normals.assign(4, {0, 0, -1});
    EXPECT_NEAR(grey(), lit(1), 0.51);
    mesh.normals.assign(4, {0.6f, 0, -0.8f});
    EXPECT_NEAR(grey(), lit(0.8), 0.51);
    mesh.normals.assign(4, {0, 0, 1});
    EXPECT_NEAR(grey(), lit(0), 0.51) << "a normal is not turned towards the eye";
}

TEST(MeshRaster, UnknownNormalsAreTakenFromTheFaces) {
    Mesh mesh = icosphere(3);
    mesh.origin = {0, 0, 4};
    const View view = axis_view(64, 64, 60);
    const Frame computed = draw(mesh, view, Shade::normal);
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0));
    EXPECT_EQ(draw(mesh, view, Shade::normal).rgb, computed.rgb);
    // On a sphere they agree with the exact ones, up to the sign that the faces' order gives.
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) mesh.normals[v] = mesh.positions[v];
    for (glm::u32vec3& t : mesh.triangles) {
        const glm::vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        if (glm::dot(glm::cross(b - a, c - a), a) < 0) std::swap(t[1], t[2]);
    }
    const Frame exact = draw(mesh, view, Shade::normal);
    mesh.normals.clear();
    const Frame faces = draw(mesh, view, Shade::normal);
    for (size_t i = 0; i < exact.rgb.size(); ++i) ASSERT_NEAR(faces.rgb[i], exact.rgb[i], 4);
}

TEST(MeshRaster, TheFrameDoesNotDependOnThreads) {
    Mesh mesh = icosphere(5);
    mesh.colours.resize(mesh.positions.size());
    for (size_t v = 0; v < mesh.colours.size(); ++v)
        mesh.colours[v] = {uint8_t(v), uint8_t(v >> 4), uint8_t(v >> 8)};
    const std::vector<glm::u32vec3> once = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), once.rbegin(), once.rend());  // every depth is a tie
    mesh.origin = {0.1, 0, 1.8};
    const View view = axis_view(400, 300, 300);
    core::set_thread_count(1);
    const Frame one = draw(mesh, view);
    for (const int threads : {2, 16}) {
        core::set_thread_count(threads);
        for (int round = 0; round < 5; ++round) {
            const Frame many = draw(mesh, view);
            ASSERT_EQ(many.rgb, one.rgb) << threads;
            ASSERT_EQ(many.depth, one.depth) << threads;
        }
    }
    core::set_thread_count(0);
}

}  // namespace
