#include "ppve/sample/raster_sampler.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "render/raster.h"
#include "scenes.h"

namespace {

using ppve_test::looking_from;

ppve::DepthImage sampled(ppve::Sampler& sampler, const ppve::Frustum& frustum, bool normals = false,
                         double bound = 0.01) {
    ppve::DepthImage image;
    image.frustum = frustum;
    ppve::prepare(sampler, bound, image);
    sampler.sample(image, normals);
    return image;
}

// Depth images cover the pixels that render::MeshRaster covers, all of them and no other, at its depths.
void expect_as_the_mesh_raster(const mesh::Mesh& mesh, const ppve::Frustum& frustum) {
    ppve::RasterSampler sampler{ppve::Clusters(mesh)};
    const ppve::DepthImage image = sampled(sampler, frustum);
    render::MeshRaster raster(mesh);
    render::Frame frame;
    raster.draw(frustum.view, {}, frame);
    size_t covered = 0;
    const double bound = ppve::bound_px(image.coding, frustum.view.focal_px);
    for (size_t p = 0; p < image.pixels(); ++p) {
        ASSERT_EQ(image.depth[p] != 0, std::isfinite(frame.depth[p]))
            << p % size_t(image.width()) << ", " << p / size_t(image.width());
        if (image.depth[p] == 0) continue;
        ++covered;
        const double depth = image.coding.depth(image.depth[p]);
        // Single precision of the frame's depths comes on top.
        ASSERT_LE(std::abs(depth - double(frame.depth[p])),
                  ppve::footprint(frustum, 1, depth) * bound * 1.001 + depth * 0x1p-23)
            << depth << " for " << frame.depth[p] << " at " << p % size_t(image.width()) << ", "
            << p / size_t(image.width());
    }
    EXPECT_GT(covered, 0u);
}

TEST(RasterSampler, CoversWhatTheMeshRasterCovers) {
    const mesh::Mesh ball = ppve_test::ball(60, 1);
    expect_as_the_mesh_raster(ball, looking_from({0, 0.4, 4}, {0, 0, 0}, 300, 200));
    expect_as_the_mesh_raster(ball, looking_from({0, 0.4, 1.3}, {0.5, 0, 0}, 300, 200));
}

TEST(RasterSampler, CoversWhatTheMeshRasterCoversOfASoupFromWithin) {
    const mesh::Mesh soup = ppve_test::soup(4000, 5);
    for (int n = 0; n < 4; ++n) {
        SCOPED_TRACE(n);
        std::mt19937_64 random{uint64_t(n)};
        const auto place = [&] {
            return glm::dvec3(ppve_test::uniform(random, -1, 1), ppve_test::uniform(random, -1, 1),
                              ppve_test::uniform(random, -1, 1));
        };
        ppve::Frustum f = looking_from(place(), place(), 160, 120);
        if (n == 1) f.view.near = 0.5, f.view.far = 1.2;
        if (n == 2) f.view.shift_px = {200, -90};
        if (n == 3) f.view.down = -f.view.down;  // mirrored
        expect_as_the_mesh_raster(soup, f);
    }
}

// Vertices on pixel centres, edges through them: what belongs to whom is decided by the exact rule.
TEST(RasterSampler, VerticesOnPixelCentresAreCoveredOnce) {
    mesh::Mesh grid;
    for (uint32_t j = 0; j < 40; ++j)
        for (uint32_t i = 0; i < 40; ++i) grid.positions.push_back({float(i) + 0.5f, float(j) + 0.5f, 0});
    for (uint32_t j = 0; j < 39; ++j)
        for (uint32_t i = 0; i < 39; ++i) {
            const uint32_t at = j * 40 + i;
            grid.triangles.push_back({at, at + 1, at + 40});
            grid.triangles.push_back({at + 1, at + 41, at + 40});
        }
    ppve::Frustum f;
    f.view.width = 41, f.view.height = 41, f.view.focal_px = 64;
    f.view.eye = {20.5, 20.5, -64}, f.view.right = {1, 0, 0}, f.view.down = {0, 1, 0},
    f.view.forward = {0, 0, 1};
    expect_as_the_mesh_raster(grid, f);
    f.projection = ppve::Projection::orthographic, f.view.focal_px = 1;
    ppve::RasterSampler sampler{ppve::Clusters(grid)};
    EXPECT_EQ(sampled(sampler, f).samples(), 39u * 39u);
}

TEST(RasterSampler, OrthographicImagesAreThoseOfAFarEye) {
    const mesh::Mesh ball = ppve_test::ball(60, 1);
    ppve::RasterSampler sampler{ppve::Clusters(ball)};
    ppve::Frustum far = looking_from({0, 0, 1e7}, {0, 0, 0}, 200, 200, 2e-5);
    ppve::Frustum ortho = looking_from({0, 0, 3}, {0, 0, 0}, 200, 200);
    ortho.projection = ppve::Projection::orthographic, ortho.view.focal_px = far.view.focal_px / 1e7;
    const ppve::DepthImage a = sampled(sampler, far), b = sampled(sampler, ortho);
    size_t same = 0;
    for (size_t p = 0; p < a.pixels(); ++p) {
        same += (a.depth[p] != 0) == (b.depth[p] != 0);
        if (a.depth[p] == 0 || b.depth[p] == 0) continue;
        ASSERT_NEAR(a.coding.depth(a.depth[p]) - 1e7, b.coding.depth(b.depth[p]) - 3, 0.05) << p;
    }
    EXPECT_GT(a.samples(), 10000u);
    EXPECT_GE(same, a.pixels() - 8);
}

TEST(RasterSampler, TheSameImageForAnyNumberOfThreads) {
    const mesh::Mesh soup = ppve_test::soup(6000, 6);
    ppve::RasterSampler sampler{ppve::Clusters(soup)};
    const ppve::Frustum f = looking_from({0, 0, 3}, {0, 0, 0}, 320, 200);
    core::set_thread_count(1);
    const ppve::DepthImage one = sampled(sampler, f, true);
    core::set_thread_count(8);
    const ppve::DepthImage many = sampled(sampler, f, true);
    core::set_thread_count(0);
    EXPECT_EQ(one.depth, many.depth);
    EXPECT_EQ(one.colour, many.colour);
    EXPECT_EQ(one.normal, many.normal);
}

TEST(RasterSampler, NormalsAreThoseOfTheSurface) {
    const mesh::Mesh ball = ppve_test::ball(120, 1);
    ppve::RasterSampler sampler{ppve::Clusters(ball)};
    const ppve::DepthImage image = sampled(sampler, looking_from({0, 0, 3}, {0, 0, 0}, 100, 100), true);
    for (int j = 0; j < 100; ++j)
        for (int i = 0; i < 100; ++i) {
            const size_t p = size_t(j) * 100 + size_t(i);
            if (image.depth[p] == 0) continue;
            // The bumps turn normals by up to 45 degrees.
            const glm::dvec3 at = ppve::position_of(image.frustum, image.coding, i, j, image.depth[p]);
            ASSERT_GT(
                std::abs(glm::dot(glm::vec3(glm::normalize(at)), ppve::octahedral_normal(image.normal[p]))),
                0.7f)
                << i << ", " << j;
        }
}

// Hidden clusters change no sample, and few are read where much is hidden or out of view.
TEST(RasterSampler, ReadsWhatAFrustumMeets) {
    mesh::Mesh layers;
    for (uint32_t layer = 0; layer < 24; ++layer)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 64; ++i) {
                const auto v = uint32_t(layers.positions.size());
                const float x = float(i) - 32, y = float(j) - 32, z = -2 * float(layer);
                for (const glm::vec2 d : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)})
                    layers.positions.push_back({x + d.x, y + d.y, z});
                layers.triangles.push_back({v, v + 1, v + 2});
                layers.triangles.push_back({v, v + 2, v + 3});
            }
    ppve::RasterSampler sampler{ppve::Clusters(layers)};
    ppve::DepthImage image;
    image.frustum = looking_from({0, 0, 20}, {0, 0, 0}, 320, 200);
    ppve::prepare(sampler, 0.01, image);
    const ppve::SampleCounts all = sampler.sample(image, false);
    EXPECT_EQ(image.samples(), image.pixels());
    EXPECT_LT(all.clusters_touched, all.clusters / 3);
    EXPECT_GT(all.clusters_hidden, 0u);
    expect_as_the_mesh_raster(layers, image.frustum);
    image.frustum = looking_from({0, 0, 20}, {0, 0, 40}, 320, 200);
    ppve::prepare(sampler, 0.01, image);
    EXPECT_EQ(sampler.sample(image, false).bytes_touched, 0u);
    EXPECT_EQ(image.samples(), 0u);
}

TEST(RasterSampler, HoldsForScalesFrom1eMinus30To1e30AndFarFromTheOrigin) {
    for (const double size : {1e-30, 1e-6, 1.0, 1e9, 1e30}) {
        SCOPED_TRACE(size);
        const mesh::Mesh ball = ppve_test::ball(24, size);
        expect_as_the_mesh_raster(ball, looking_from({0, 0, 3 * size}, {0, 0, 0}, 120, 80));
    }
    const glm::dvec3 away(4e6, -7e6, 2e5);
    expect_as_the_mesh_raster(ppve_test::ball(40, 1, away),
                              looking_from(away + glm::dvec3(0, 0, 3), away, 120, 80));
}

TEST(RasterSampler, ACloudIsSquaresAboutItsDiscs) {
    mesh::Mesh cloud;
    for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 20; ++i) {
            cloud.positions.push_back({float(i), float(j), 0});
            cloud.normals.push_back({0, 0, 1});
            cloud.radii.push_back(0.5f);
        }
    ppve::RasterSampler sampler{ppve::Clusters(cloud)};
    ppve::Frustum f = looking_from({9.5, 9.5, 10}, {9.5, 9.5, 0}, 200, 200);
    f.projection = ppve::Projection::orthographic, f.view.focal_px = 8;
    // Squares that touch: no gap between them.
    EXPECT_EQ(sampled(sampler, f).samples(), 160u * 160u);
}

}  // namespace
