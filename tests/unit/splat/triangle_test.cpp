// Leaves that are triangles: circles, runs, and that the file gives back what went in.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "splat/build/run_packer.h"
#include "splat/extract.h"
#include "splat/triangle_reader.h"
#include "splat/verify.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

using Kind = splat::TriangleCircle::Kind;
using Corners = std::array<std::array<int64_t, 3>, 3>;

constexpr splat::BuildOptions kTriangles{.leaf = splat::Leaf::triangle};

glm::dvec3 random_point(Random& random) {
    return random.direction() * random.unit();
}

std::array<int64_t, 3> as_array(const glm::i64vec3& p) {
    return {p.x, p.y, p.z};
}

// All triangles, each begun with its least corner.
template <class Triangles>
std::vector<Corners> sorted(Triangles triangles) {
    for (Corners& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

std::vector<Corners> triangles_of(const splat::Model& model) {
    std::vector<Corners> all;
    splat::BlockView nodes;
    splat::BlockTriangles triangles;
    for (uint64_t b = 0; b < model.header().node_blocks(); ++b) {
        nodes.open(model, b);
        triangles.open(model, nodes);
        for (const auto& placed : triangles.runs())
            for (uint32_t t = 0; t < placed.run.triangles(); ++t) {
                const glm::u32vec3 e = placed.run.entries(t);
                all.push_back({as_array(placed.run.position(e.x)), as_array(placed.run.position(e.y)),
                               as_array(placed.run.position(e.z))});
            }
    }
    return sorted(all);
}

// The mesh's triangles on the model's lattice.
std::vector<Corners> on_lattice(const mesh::Mesh& mesh, const splat::Header& h) {
    std::vector<Corners> all;
    for (const glm::u32vec3& t : mesh.triangles) {
        Corners corners;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 at =
                (glm::dvec3(mesh.positions[t[k]]) + (mesh.origin - h.origin)) * (1 / h.scale);
            for (int axis = 0; axis < 3; ++axis)
                corners[size_t(k)][size_t(axis)] = std::lround(std::ldexp(at[axis], int(h.lattice_bits)));
        }
        all.push_back(corners);
    }
    return sorted(all);
}

int64_t largest_difference(const std::vector<Corners>& a, const std::vector<Corners>& b) {
    int64_t most = 0;
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t k = 0; k < 3; ++k)
            for (size_t axis = 0; axis < 3; ++axis)
                most = std::max(most, std::abs(a[i][k][axis] - b[i][k][axis]));
    return most;
}

mesh::Mesh cube() {
    mesh::Mesh m;
    for (int v = 0; v < 8; ++v) m.positions.emplace_back(v & 1, v >> 1 & 1, v >> 2 & 1);
    for (const glm::u32vec4 q :
         {glm::u32vec4(0, 2, 3, 1), {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
        m.triangles.emplace_back(q.x, q.y, q.z), m.triangles.emplace_back(q.x, q.z, q.w);
    return m;
}

uint64_t smooth_of(const mesh::Mesh& mesh) {
    splat::BuildReport report;
    build_bytes(mesh, kTriangles, &report);
    return report.triangles.smooth;
}

}  // namespace

TEST(TriangleCircle, IsTheSmallestThatHoldsTheTriangle) {
    Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const glm::dvec3 p[3] = {random_point(random), random_point(random), random_point(random)};
        const splat::TriangleCircle c = splat::smallest_circle(p[0], p[1], p[2]);
        ASSERT_NE(c.kind, Kind::degenerate);
        int on_rim = 0;
        double longest = 0;
        for (int k = 0; k < 3; ++k) {
            const double distance = glm::length(p[k] - c.centre);
            ASSERT_LE(distance, c.radius * (1 + 1e-9));
            on_rim += distance > c.radius * (1 - 1e-9);
            longest = std::max(longest, glm::length(p[k] - p[(k + 1) % 3]));
        }
        ASSERT_GE(on_rim, c.kind == Kind::acute ? 3 : 2);
        if (c.kind == Kind::obtuse) {
            ASSERT_NEAR(2 * c.radius, longest, 1e-12);
        }
        ASSERT_LE(c.radius, longest / std::sqrt(3.0) * (1 + 1e-9));
    }
}

TEST(TriangleCircle, OfWhatHasNoAreaIsAboutItsLongestSide) {
    const glm::dvec3 a(1, 2, 3), b(3, 2, 3), c(2.5, 2, 3);
    for (const auto& [p, q, r, radius] :
         {std::tuple(a, b, c, 1.0), {c, a, b, 1.0}, {a, a, b, 1.0}, {a, a, a, 0.0}}) {
        const splat::TriangleCircle circle = splat::smallest_circle(p, q, r);
        EXPECT_EQ(circle.kind, Kind::degenerate);
        EXPECT_DOUBLE_EQ(circle.radius, radius);
    }
}

TEST(CornerNormal, IsCloseToWhatItCodes) {
    Random random(2);
    for (int i = 0; i < 100000; ++i) {
        const glm::dvec3 n =
            i < 3 ? glm::dvec3(i == 0, i == 1, i == 2) * (i % 2 ? -1.0 : 1.0) : random.direction();
        const glm::dvec3 decoded(splat::decode_corner_normal(splat::encode_corner_normal(n)));
        ASSERT_NEAR(glm::length(decoded), 1, 1e-6);
        ASSERT_LT(glm::length(decoded - n), 0.00105) << i;  // 0.06 degrees
    }
}

using PackedCorners = std::array<splat::RunPacker::Corner, 3>;

// As they may have come back: begun with another corner.
bool is_same(const splat::TriangleRun& run, uint32_t triangle, const PackedCorners& packed,
             bool has_normals) {
    const glm::u32vec3 entries = run.entries(triangle);
    for (int first = 0; first < 3; ++first) {
        bool is_same = true;
        for (int k = 0; k < 3; ++k) {
            const splat::RunPacker::Corner& c = packed[size_t(first + k) % 3];
            is_same &= run.position(entries[k]) == glm::i64vec3(c.position) &&
                       (!has_normals || run.normal_code(entries[k]) == c.normal);
        }
        if (is_same) return true;
    }
    return false;
}

// Bytes of a run, with what may be read behind it: anything.
struct RunBytes {
    explicit RunBytes(const std::vector<std::byte>& run, size_t count)
        : bytes(run.begin(), run.begin() + ptrdiff_t(count)) {
        bytes.resize(count + splat::kRunReadAhead, std::byte{0xa5});
    }
    std::span<const std::byte> run() const {
        return std::span(bytes).first(bytes.size() - splat::kRunReadAhead);
    }
    std::vector<std::byte> bytes;
};

TEST(TriangleRun, GivesBackWhatWasPacked) {
    Random random(3);
    for (int round = 0; round < 300; ++round) {
        const uint32_t lattice_bits = 1 + uint32_t(random.bits() % splat::kMaxLatticeBits);
        const auto limit = int64_t(1) << lattice_bits;
        const size_t count = 1 + random.bits() % splat::kMostRunTriangles;
        // From soups of triangles to fans of few vertices.
        const uint64_t vertices = 3 + random.bits() % (round % 3 ? 1000 : 20);
        const bool may_be_smooth = round % 2, may_be_flat = round % 4 != 1;
        splat::RunPacker packer(lattice_bits);
        std::vector<PackedCorners> packed;
        std::vector<bool> smooth;
        while (packed.size() < count) {
            PackedCorners corners;
            for (auto& c : corners) {
                c.vertex = uint32_t(random.bits() % vertices), c.normal = c.vertex * 1234567 & 0x7ff7ff;
                for (int axis = 0; axis < 3; ++axis)
                    c.position[axis] =
                        int(int64_t((c.vertex + 1) * uint64_t(axis + 77777771)) % (2 * limit + 1) - limit);
            }
            if (corners[0].vertex == corners[1].vertex || corners[1].vertex == corners[2].vertex ||
                corners[2].vertex == corners[0].vertex)
                continue;
            const bool is_smooth = may_be_smooth && (!may_be_flat || random.bits() % 2);
            packer.add({corners[0], corners[1], corners[2]}, is_smooth);
            packed.push_back(corners), smooth.push_back(is_smooth);
        }
        ASSERT_EQ(packer.is_full(), count == splat::kMostRunTriangles);
        std::vector<std::byte> bytes;
        packer.finish(bytes);
        ASSERT_TRUE(packer.is_empty());
        const RunBytes whole(bytes, bytes.size());
        splat::TriangleRun run;
        ASSERT_EQ(run.read(whole.run(), lattice_bits), "");
        ASSERT_EQ(run.size_bytes(), bytes.size());
        ASSERT_EQ(run.triangles(), packed.size());
        for (uint32_t t = 0; t < run.triangles(); ++t) {
            ASSERT_EQ(run.is_smooth(t), smooth[t]);
            ASSERT_TRUE(is_same(run, t, packed[t], smooth[t])) << round << " " << t;
        }
        for (size_t size = splat::kRunSizeBytes; size < bytes.size(); size += 1 + bytes.size() / 50) {
            // Cut off, as its size says so, too.
            RunBytes part(bytes, size);
            part.bytes[0] = std::byte(size & 255), part.bytes[1] = std::byte(size >> 8);
            ASSERT_NE(run.read(part.run(), lattice_bits), "") << size;
        }
    }
}

// Every flipped bit is a fault, or a run within its bounds.
TEST(TriangleRun, DamagedIsAFaultOrARunWithinBounds) {
    Random random(4);
    constexpr uint32_t kLatticeBits = 10;
    splat::RunPacker packer(kLatticeBits);
    for (uint32_t t = 0; t < 60; ++t) {
        splat::RunPacker::Corner corners[3];
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t v = (t + k + (t % 7 == 0 ? 2 * k : 0)) % 40;
            corners[k] = {v, {int(v * 25 % 1000), int(v * v % 1000), int(v % 5)}, v * 4097 % 0x7ff7ff};
        }
        packer.add(corners, t % 3 > 0);
    }
    std::vector<std::byte> bytes;
    packer.finish(bytes);
    size_t faults = 0;
    for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        RunBytes damaged(bytes, bytes.size());
        damaged.bytes[bit / 8] ^= std::byte(1u << bit % 8);
        splat::TriangleRun run;
        if (!run.read(damaged.run(), kLatticeBits).empty()) {
            ++faults;
            continue;
        }
        for (uint32_t t = 0; t < run.triangles(); ++t)
            for (int k = 0; k < 3; ++k) ASSERT_LT(run.entries(t)[k], run.corners());
        for (uint32_t e = 0; e < run.corners(); ++e)
            for (int axis = 0; axis < 3; ++axis)
                ASSERT_LE(std::abs(run.position(e)[axis]), 1 << kLatticeBits);
    }
    EXPECT_GT(faults, bytes.size());
}

TEST(TriangleLeaves, AreTheInputsTrianglesOnTheLattice) {
    for (const NamedMesh& m : generated_meshes()) {
        splat::BuildReport report;
        const Bytes bytes = build_bytes(m.mesh, kTriangles, &report);
        const splat::Model model = open_model(bytes);
        const splat::Header& h = model.header();
        EXPECT_EQ(h.leaf_count, m.mesh.triangles.size()) << m.name;
        EXPECT_EQ(report.triangles.acute + report.triangles.obtuse + report.triangles.degenerate,
                  h.leaf_count)
            << m.name;
        const std::vector<Corners> found = triangles_of(model), wanted = on_lattice(m.mesh, h);
        ASSERT_EQ(found.size(), wanted.size()) << m.name;
        // 1 where a coordinate is half way between two steps.
        EXPECT_LE(largest_difference(found, wanted), 1) << m.name;
        EXPECT_NO_THROW(splat::verify(memory_file(bytes))) << m.name;
    }
}

TEST(TriangleLeaves, FanOutIsAtLeastFour) {
    const splat::Header h = build_model(bumpy_torus(60, 160), kTriangles).header();
    EXPECT_GE(double(h.node_count) / double(h.node_count - h.leaf_count + 1), 4);
}

TEST(TriangleLeaves, AreTheSameForAnyNumberOfThreads) {
    const mesh::Mesh mesh = bumpy_torus(300, 400, true);
    core::set_thread_count(1);
    const Bytes one = build_bytes(mesh, kTriangles);
    core::set_thread_count(7);
    EXPECT_EQ(build_bytes(mesh, kTriangles), one);
    core::set_thread_count(0);
}

TEST(TriangleLeaves, TakeAtMostThirteenBytesAndElevenWithoutNormals) {
    mesh::Mesh mesh = bumpy_torus(300, 400);
    const auto bytes_of = [&] {
        return double(build_bytes(mesh, kTriangles).size()) / double(mesh.triangles.size());
    };
    EXPECT_LE(bytes_of(), 13.0);
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0));  // no vertex has one: all triangles are flat
    EXPECT_LE(bytes_of(), 11.0);
}

TEST(TriangleLeaves, AreSmoothButAtCreases) {
    EXPECT_EQ(smooth_of(icosphere(4)), icosphere(4).triangles.size());
    EXPECT_EQ(smooth_of(cube()), 0u);
    mesh::Mesh with_normals = cube();
    for (const glm::vec3& p : with_normals.positions)
        with_normals.normals.push_back(glm::normalize(p - glm::vec3(0.5f)));
    EXPECT_EQ(smooth_of(with_normals), 12u) << "the input says what is smooth";
}

TEST(TriangleLeaves, BareParticlesAreRefused) {
    try {
        build_bytes(cloud(100), kTriangles);
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(),
                     "test: has no triangles to be leaves; bare points are built with --leaf point");
    }
}

TEST(TriangleLeaves, WhatTheLatticeCannotTellApartIsCounted) {
    // A ball of 1e-9 beside a triangle of 1: no lattice of 30 bits has both.
    mesh::Mesh mesh = icosphere(2);
    const auto small = uint32_t(mesh.positions.size());
    for (glm::vec3& p : mesh.positions) p *= 1e-12f;
    for (const glm::vec3 p : {glm::vec3(0), {1, 0, 0}, {0, 1, 0}}) mesh.positions.push_back(p);
    mesh.triangles.emplace_back(small, small + 1, small + 2);
    splat::BuildReport report;
    const Bytes bytes = build_bytes(mesh, kTriangles, &report);
    EXPECT_EQ(report.triangles.merged_vertices, small);
    EXPECT_EQ(report.triangles.flattened, mesh.triangles.size() - 1);
    EXPECT_EQ(report.header.leaf_count, mesh.triangles.size());
    EXPECT_NO_THROW(splat::verify(memory_file(bytes)));
}

TEST(TriangleLeaves, EveryFlippedBitIsFound) {
    Bytes bytes = build_bytes(icosphere(1), kTriangles);
    ASSERT_NO_THROW(splat::verify(memory_file(bytes)));
    for (size_t bit = 0; bit < bytes.size() * 8; bit += bit < 8 * splat::kHeaderSize ? 1 : 5) {
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        EXPECT_THROW(splat::verify(memory_file(bytes)), core::Error) << bit;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
}

TEST(TriangleLeaves, ChangedRunsAreFoundBehindTheirChecksums) {
    const Bytes whole = build_bytes(icosphere(2), kTriangles);
    const splat::Header h = splat::parse_header(whole, "");
    const size_t first = h.block_at(h.node_blocks());
    size_t found = 0, tried = 0;
    for (size_t bit = first * 8 + 32; bit < (first + 400) * 8; bit += 3, ++tried) {
        Bytes bytes = whole;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        repair_checksums(bytes);
        try {
            splat::verify(memory_file(bytes));
            triangles_of(open_model(bytes));
        } catch (const core::Error&) {
            ++found;
        }
    }
    EXPECT_GT(found, tried / 10) << "what moves a corner by much is found";
    EXPECT_LT(found, tried) << "what changes a normal is not";
}

TEST(TriangleLeaves, OfAPrefixAreThoseThatAreThere) {
    const Bytes whole = build_bytes(bumpy_torus(60, 160), kTriangles);
    const splat::Header h = splat::parse_header(whole, "");
    size_t last = 0;
    for (uint64_t blocks = h.node_blocks(); blocks <= h.block_count; blocks += 1) {
        const Bytes bytes(whole.begin(), whole.begin() + ptrdiff_t(h.block_at(blocks)));
        const size_t count = triangles_of(open_model(bytes)).size();
        EXPECT_GE(count, last);
        if (blocks == h.node_blocks()) {
            EXPECT_EQ(count, 0u);
        }
        if (blocks < h.block_count) {
            EXPECT_THROW(splat::verify(memory_file(bytes)), core::Error);
        }
        last = count;
    }
    EXPECT_EQ(last, h.leaf_count);
}
