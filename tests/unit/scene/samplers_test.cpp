// The samplers against each other: what the exact rasteriser says, others come near to.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "core/error.h"
#include "core/file.h"
#include "ppve/sample/embree_sampler.h"
#include "ppve/sample/raster_sampler.h"
#include "scene/gl_sampler.h"
#include "scene/samplers.h"
#include "scene/surface_file.h"
#include "test_meshes.h"

namespace {

using ppve::DepthImage;

DepthImage sampled(ppve::Sampler& sampler, bool normals) {
    geom::Camera camera;
    camera.eye = {0.5, 3, 4}, camera.target = {0, 0, 0}, camera.fovy_deg = 30;
    DepthImage image;
    image.frustum.view = geom::make_view(camera, 200, 150);
    ppve::prepare(sampler, 0.05, image);
    sampler.sample(image, normals);
    return image;
}

// Shares of pixels that are covered in one and not in the other; differences where both are.
void expect_near(const DepthImage& a, const DepthImage& b) {
    size_t covered = 0, other = 0, far = 0, coloured = 0, turned = 0;
    for (size_t p = 0; p < a.pixels(); ++p) {
        covered += a.depth[p] != 0;
        other += (a.depth[p] != 0) != (b.depth[p] != 0);
        if (a.depth[p] == 0 || b.depth[p] == 0) continue;
        const double da = a.coding.depth(a.depth[p]), db = b.coding.depth(b.depth[p]);
        far += std::abs(da - db) > 0.001;
        for (int shift = 0; shift < 24; shift += 8)
            coloured += std::abs(int(a.colour[p] >> shift & 0xff) - int(b.colour[p] >> shift & 0xff)) > 4;
        if (!a.normal.empty())
            turned +=
                glm::dot(ppve::octahedral_normal(a.normal[p]), ppve::octahedral_normal(b.normal[p])) < 0.98f;
    }
    ASSERT_GT(covered, 5000u);
    EXPECT_LE(other, covered / 200);
    EXPECT_LE(far, covered / 100);
    EXPECT_LE(coloured, covered / 50);
    EXPECT_LE(turned, covered / 50);
}

void expect_like_raster(const std::function<std::unique_ptr<ppve::Sampler>(mesh::Mesh)>& open) {
    const mesh::Mesh torus = splat_test::bumpy_torus(80, 50, true);
    std::unique_ptr<ppve::Sampler> other;
    try {
        other = open(torus);
    } catch (const core::Error& why) {
        GTEST_SKIP() << why.what();
    }
    ppve::RasterSampler raster{ppve::Clusters(torus)};
    for (const bool normals : {false, true}) expect_near(sampled(raster, normals), sampled(*other, normals));
}

TEST(Samplers, OpenGlSeesWhatTheRasteriserSees) {
    expect_like_raster([](mesh::Mesh mesh) { return scene::open_gl_sampler(std::move(mesh), true); });
}

TEST(Samplers, EmbreeSeesWhatTheRasteriserSees) {
    expect_like_raster([](mesh::Mesh mesh) { return ppve::open_embree_sampler(std::move(mesh)); });
}

class SamplerFiles : public testing::Test {
  protected:
    void SetUp() override {
        std::string name = testing::TempDir() + "samplersXXXXXX";
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string write(const std::string& name, std::span<const std::byte> bytes) const {
        const std::string path = folder_ / name;
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        return path;
    }
    std::string write(const std::string& name, const std::string& text) const {
        return write(name, std::as_bytes(std::span(text)));
    }

    std::filesystem::path folder_;
};

// A mesh, its clusters in a file, a model of it with triangles as leaves, and one of its points.
TEST_F(SamplerFiles, AMeshItsClustersAndItsModelsLookTheSame) {
    const mesh::Mesh torus = splat_test::bumpy_torus(80, 50, true);
    const std::string ply = write("torus.ply", mesh::to_ply(torus));
    const auto mesh = scene::open_sampler({ply}, {});
    const DepthImage expected = sampled(*mesh, false);
    scene::write_clusters({ply}, folder_ / "torus.clusters");
    const DepthImage mapped = sampled(*scene::open_sampler({folder_ / "torus.clusters"}, {}), false);
    EXPECT_EQ(mapped.depth, expected.depth);
    EXPECT_EQ(mapped.colour, expected.colour);

    splat::BuildOptions triangles;
    triangles.leaf = splat::Leaf::triangle;
    const auto model = splat_test::build_bytes(torus, triangles);
    const DepthImage of_model = sampled(*scene::open_sampler({write("torus.qs", model)}, {}), false);
    size_t other = 0;
    for (size_t p = 0; p < expected.pixels(); ++p)
        other += (expected.depth[p] != 0) != (of_model.depth[p] != 0);
    EXPECT_LE(other, expected.samples() / 100);

    // Points are squares: no hole in them, and no much larger outline.
    const DepthImage of_points =
        sampled(*scene::open_sampler({write("points.qs", splat_test::build_bytes(torus))}, {}), false);
    size_t holes = 0;
    for (size_t p = 0; p < expected.pixels(); ++p) holes += expected.depth[p] != 0 && of_points.depth[p] == 0;
    EXPECT_LE(holes, expected.samples() / 200);
    EXPECT_LE(of_points.samples(), expected.samples() * 5 / 4);
}

TEST_F(SamplerFiles, WhatDoesNotGoTogetherIsRefused) {
    const std::string ply = write("a.ply", mesh::to_ply(splat_test::icosphere(1)));
    const std::string cloud = write("b.ply", mesh::to_ply(splat_test::cloud(50)));
    EXPECT_THROW(scene::open_sampler({ply, cloud}, {}), core::Error);
    EXPECT_NO_THROW(scene::open_sampler({ply, ply}, {}));
    scene::write_clusters({ply}, folder_ / "a.clusters");
    EXPECT_THROW(scene::open_sampler({folder_ / "a.clusters", ply}, {}), core::Error);
    scene::SamplerOptions embree;
    embree.kind = scene::SamplerKind::embree;
    EXPECT_THROW(scene::open_sampler({folder_ / "a.clusters"}, embree), core::Error);
}

// A flipped bit anywhere in a file of clusters is an error, when it is opened or when it is read.
TEST_F(SamplerFiles, DamagedClustersAreRefused) {
    const std::string ply = write("a.ply", mesh::to_ply(splat_test::icosphere(2)));
    scene::write_clusters({ply}, folder_ / "a.clusters");
    std::vector<std::byte> bytes;
    {
        const core::InputFile file(folder_ / "a.clusters");
        bytes.assign(file.bytes().begin(), file.bytes().end());
    }
    // Between the clusters there are bytes that mean nothing: of one cluster there are none but at the end.
    const size_t step = bytes.size() / 60;
    for (size_t at = 0; at + 64 < bytes.size(); at += step) {
        if (at >= 56 && at < 64) continue;
        auto damaged = bytes;
        damaged[at] ^= std::byte{16};
        const std::string path = write("damaged.clusters", damaged);
        EXPECT_THROW(sampled(*scene::open_sampler({path}, {}), false), core::Error) << at;
    }
    for (const size_t size : {size_t(9), size_t(63), bytes.size() / 2, bytes.size() - 1})
        EXPECT_THROW(scene::open_sampler({write("short.clusters", std::span(bytes).first(size))}, {}),
                     core::Error)
            << size;
}

}  // namespace
