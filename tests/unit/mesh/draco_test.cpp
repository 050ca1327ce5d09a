#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <gtest/gtest.h>

#include <array>

#include "core/error.h"
#include "mesh/mesh.h"
#include "mesh_check.h"

namespace {

std::span<const std::byte> bytes_of(const draco::EncoderBuffer& buffer) {
    return std::as_bytes(std::span<const char>(buffer.data(), buffer.size()));
}

// Two triangles of a square with a colour and a normal a vertex.
draco::EncoderBuffer encoded_square() {
    using Vec = std::array<float, 3>;
    const Vec corner[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const std::array<uint8_t, 3> colour[4] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {9, 9, 9}};
    const Vec up = {0, 0, 1};
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(2);
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
    const int colours = builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8);
    const int faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    for (uint32_t f = 0; f < 2; ++f) {
        const auto& v = faces[f];
        const draco::FaceIndex face(f);
        builder.SetAttributeValuesForFace(position, face, &corner[v[0]], &corner[v[1]], &corner[v[2]]);
        builder.SetAttributeValuesForFace(normal, face, &up, &up, &up);
        builder.SetAttributeValuesForFace(colours, face, &colour[v[0]], &colour[v[1]], &colour[v[2]]);
    }
    const std::unique_ptr<draco::Mesh> square = builder.Finalize();
    draco::EncoderBuffer buffer;
    draco::Encoder encoder;
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*square, &buffer).ok());
    return buffer;
}

TEST(Draco, ReadsAMeshWithNormalsAndColours) {
    const draco::EncoderBuffer buffer = encoded_square();
    const mesh::ReadResult result = mesh::read_mesh_bytes(bytes_of(buffer), "square.drc");
    check_invariants(result);
    EXPECT_EQ(result.counts.format, "draco");
    ASSERT_EQ(result.mesh.positions.size(), 4u);
    EXPECT_EQ(result.mesh.triangles.size(), 2u);
    ASSERT_EQ(result.mesh.normals.size(), 4u);
    ASSERT_EQ(result.mesh.colours.size(), 4u);
    for (size_t v = 0; v < 4; ++v) {
        const glm::vec3 p = result.mesh.positions[v];
        const glm::u8vec3 expected = p.y < 0.5f
                                         ? (p.x < 0.5f ? glm::u8vec3(255, 0, 0) : glm::u8vec3(0, 255, 0))
                                         : (p.x < 0.5f ? glm::u8vec3(9) : glm::u8vec3(0, 0, 255));
        EXPECT_EQ(result.mesh.colours[v], expected) << v;
        EXPECT_GT(result.mesh.normals[v].z, 0.99f);
    }
}

TEST(Draco, ReadsACloud) {
    constexpr uint32_t kCount = 100;
    draco::PointCloudBuilder builder;
    builder.Start(kCount);
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (uint32_t i = 0; i < kCount; ++i) {
        const std::array<float, 3> p = {static_cast<float>(i), 2, 3};
        builder.SetAttributeValueForPoint(position, draco::PointIndex(i), p.data());
    }
    const std::unique_ptr<draco::PointCloud> cloud = builder.Finalize(false);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(draco::Encoder().EncodePointCloudToBuffer(*cloud, &buffer).ok());
    const mesh::ReadResult result = mesh::read_mesh_bytes(bytes_of(buffer), "cloud.drc");
    check_invariants(result);
    EXPECT_TRUE(result.mesh.is_cloud());
    ASSERT_EQ(result.mesh.positions.size(), kCount);
    float sum = 0;
    for (const glm::vec3& p : result.mesh.positions) sum += p.x;
    EXPECT_NEAR(sum, 4950, 1);
}

TEST(Draco, RefusesWhatOnlyBeginsLikeIt) {
    const std::string path = QS_TEST_DATA "/bad/mesh-not-a-draco.drc";
    try {
        mesh::read_mesh(path);
        FAIL() << "accepted";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.what(), path + ": Draco: Failed to decode geometry data");
    }
}

TEST(Draco, RefusesEveryTruncation) {
    const draco::EncoderBuffer buffer = encoded_square();
    for (size_t size = 0; size < buffer.size(); ++size)
        EXPECT_THROW(mesh::read_mesh_bytes(bytes_of(buffer).first(size), "square.drc"), core::Error) << size;
}

TEST(Draco, RefusesOrReadsEverySingleBitFlip) {
    const draco::EncoderBuffer buffer = encoded_square();
    for (size_t bit = 0; bit < 8 * buffer.size(); ++bit) {
        std::vector<char> bytes(buffer.data(), buffer.data() + buffer.size());
        bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
        try {
            check_invariants(mesh::read_mesh_bytes(std::as_bytes(std::span(bytes)), "square.drc"));
        } catch (const core::Error&) {
        }
    }
}

}  // namespace
