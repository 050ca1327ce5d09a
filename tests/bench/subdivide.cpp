// subdivide IN N OUT.ply: splits every triangle into four at the midpoints of its edges, N times.
// Makes the larger cases of the benchmarks out of a real scan; triangles that share an edge share
// its midpoint.
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "mesh/mesh.h"

namespace {

// One of the three edges of a triangle, in the bucket of its lower vertex.
struct HalfEdge {
    uint32_t high;    // the edge's higher vertex
    uint32_t corner;  // 3 * triangle + the corner where the edge begins
};

struct Edges {
    std::vector<uint32_t> of_corner;     // edge that begins at corner 3 * triangle + k
    std::vector<glm::u32vec2> vertices;  // of each edge, the lower first
};

// Edges in the order of their lower, then higher vertex.
Edges find_edges(const mesh::Mesh& mesh) {
    std::vector<uint32_t> begin(mesh.positions.size() + 1, 0);
    const auto each_corner = [&](const auto& visit) {
        for (size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]});
                visit(low, high, static_cast<uint32_t>(3 * t + static_cast<size_t>(k)));
            }
    };
    each_corner([&](uint32_t low, uint32_t, uint32_t) { ++begin[low + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<HalfEdge> sorted(3 * mesh.triangles.size());
    std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
    each_corner([&](uint32_t low, uint32_t high, uint32_t corner) { sorted[next[low]++] = {high, corner}; });

    Edges edges;
    edges.of_corner.resize(sorted.size());
    for (uint32_t low = 0; low < mesh.positions.size(); ++low) {
        std::sort(&sorted[0] + begin[low], &sorted[0] + begin[low + 1],
                  [](const HalfEdge& a, const HalfEdge& b) { return a.high < b.high; });
        for (uint32_t i = begin[low]; i < begin[low + 1]; ++i) {
            if (i == begin[low] || sorted[i].high != sorted[i - 1].high)
                edges.vertices.emplace_back(low, sorted[i].high);
            edges.of_corner[sorted[i].corner] = static_cast<uint32_t>(edges.vertices.size() - 1);
        }
    }
    return edges;
}

mesh::Mesh subdivide(mesh::Mesh mesh) {
    // Corners of the result are numbered in 32 bits.
    if (mesh.triangles.size() > ~uint32_t{0} / 12) throw core::Error("too many triangles to subdivide");
    const Edges edges = find_edges(mesh);
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    const size_t count = first + edges.vertices.size();
    mesh.positions.reserve(count);
    mesh.colours.reserve(mesh.colours.empty() ? 0 : count);
    for (const glm::u32vec2& e : edges.vertices) {
        mesh.positions.push_back(0.5f * mesh.positions[e.x] + 0.5f * mesh.positions[e.y]);
        if (!mesh.colours.empty())
            mesh.colours.push_back(
                glm::u8vec3((glm::uvec3(mesh.colours[e.x]) + glm::uvec3(mesh.colours[e.y])) / 2u));
    }
    // Midpoints do not lie on the true surface: normals are left to whoever reads the mesh.
    mesh.normals.clear();

    std::vector<glm::u32vec3> triangles;
    triangles.reserve(4 * mesh.triangles.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::u32vec3 v = mesh.triangles[t];
        const uint32_t* edge = &edges.of_corner[3 * t];
        const glm::u32vec3 m(first + edge[0], first + edge[1], first + edge[2]);
        triangles.insert(triangles.end(), {{v.x, m.x, m.z}, {v.y, m.y, m.x}, {v.z, m.z, m.y}, m});
    }
    mesh.triangles = std::move(triangles);
    return mesh;
}

}  // namespace

int main(int argc, char** argv) {
    int times = 0;
    if (argc != 4 || std::sscanf(argv[2], "%d", &times) != 1 || times < 0) {
        std::fputs("usage: subdivide IN N OUT.ply\n", stderr);
        return 2;
    }
    try {
        mesh::Mesh mesh = mesh::read_mesh(argv[1]).mesh;
        for (int n = 0; n < times; ++n) mesh = subdivide(std::move(mesh));
        core::OutputFile out(argv[3]);
        out.write(mesh::to_ply(mesh));
        out.commit();
        std::printf("%zu vertices, %zu faces\n", mesh.positions.size(), mesh.triangles.size());
    } catch (const core::Error& error) {
        std::fprintf(stderr, "subdivide: %s\n", error.what());
        return 1;
    }
}
