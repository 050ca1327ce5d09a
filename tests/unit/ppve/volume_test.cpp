#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "ppve/sample/volume_sampler.h"
#include "scenes.h"

namespace {

// A folder of this test's own, with a volume of distances from the middle.
class VolumeSampler : public testing::Test {
  protected:
    void SetUp() override {
        std::string name = testing::TempDir() + "volumeXXXXXX";
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    static constexpr int kSide = 33;

    std::string write(const std::string& header, size_t bytes_missing = 0) {
        std::ofstream(folder_ / "v.mhd") << header;
        std::vector<float> values;
        for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x)
                    values.push_back(float(glm::length(glm::dvec3(x, y, z) - 0.5 * (kSide - 1))));
        std::ofstream data(folder_ / "v.raw", std::ios::binary);
        data.write(reinterpret_cast<const char*>(values.data()),
                   std::streamsize(4 * values.size() - bytes_missing));
        data.close();
        return folder_ / "v.mhd";
    }
    static std::string header() {
        return "NDims = 3\nDimSize = 33 33 33\nElementSpacing = 0.125 0.125 0.125\nOffset = -2 -2 -2\n"
               "ElementType = MET_FLOAT\nElementDataFile = v.raw\n";
    }

    std::filesystem::path folder_;
};

// A ball of radius 8 cells, or 1.
TEST_F(VolumeSampler, FindsTheSurfaceOfABallWithoutHoles) {
    ppve::VolumeSampler sampler(ppve::Volume(write(header())), 8);
    for (const glm::dvec3 eye : {glm::dvec3(0, 0, 5), glm::dvec3(3, 2, -4), glm::dvec3(0, 0, 0)}) {
        ppve::DepthImage image;
        image.frustum = ppve_test::looking_from(
            eye, eye == glm::dvec3(0) ? glm::dvec3(1, 0, 0) : glm::dvec3(0), 160, 100, 24);
        ppve::prepare(sampler, 0.01, image);
        const ppve::SampleCounts counts = sampler.sample(image, true);
        EXPECT_LT(counts.clusters_touched, counts.clusters);
        for (int j = 0; j < 100; ++j)
            for (int i = 0; i < 160; ++i) {
                const size_t p = size_t(j) * 160 + size_t(i);
                const geom::View& v = image.frustum.view;
                const glm::dvec2 at = (glm::dvec2(i + 0.5, j + 0.5) - v.principal()) / v.focal_px;
                const glm::dvec3 along = glm::normalize(v.forward + v.right * at.x + v.down * at.y);
                // How near the ray comes to the middle; a cell's distances are off by some hundredths.
                const double miss = glm::length(glm::cross(along, -eye));
                if (miss < 0.99) {
                    ASSERT_NE(image.depth[p], 0u) << i << ", " << j;
                }
                if (miss > 1.01) {
                    ASSERT_EQ(image.depth[p], 0u) << i << ", " << j;
                }
                if (image.depth[p] == 0) continue;
                const glm::dvec3 hit = ppve::position_of(image.frustum, image.coding, i, j, image.depth[p]);
                ASSERT_NEAR(glm::length(hit), 1, 0.01);
                if (!(miss < 0.9)) continue;
                ASSERT_GT(std::abs(glm::dot(glm::vec3(glm::normalize(hit)),
                                            ppve::octahedral_normal(image.normal[p]))),
                          0.98f);
            }
    }
}

TEST_F(VolumeSampler, DataOfAnotherLengthAreRefused) {
    EXPECT_THROW(ppve::Volume{write(header(), 1)}, core::Error);
}

TEST_F(VolumeSampler, HeadersThatAreNotReadAreRefused) {
    const auto refused = [&](const std::string& from, const std::string& to) {
        std::string text = header();
        text.replace(text.find(from), from.size(), to);
        EXPECT_THROW(ppve::parse_volume_header(text, "v.mhd"), core::Error) << to;
    };
    EXPECT_NO_THROW(ppve::parse_volume_header(header(), "v.mhd"));
    refused("NDims = 3", "NDims = 2");
    refused("33 33 33", "33 33");
    refused("33 33 33", "33 33 1");
    refused("33 33 33", "33 33 99999999999");
    refused("0.125 0.125 0.125", "0.125 nan 0.125");
    refused("0.125 0.125 0.125", "0.125 -1 0.125");
    refused("MET_FLOAT", "MET_DOUBLE");
    refused("v.raw", "../v.raw");
    refused("v.raw", "/etc/passwd");
    refused("v.raw", "LOCAL");
    refused("NDims = 3", "CompressedData = True\nNDims = 3");
    refused("NDims = 3", "TransformMatrix = 0 1 0 1 0 0 0 0 1\nNDims = 3");
    refused("NDims = 3", "NDims");
}

}  // namespace
