#include "test_models.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace pm_test {

Bytes build_bytes(const mesh::Mesh& mesh, const pm::BuildOptions& options) {
    core::OutputFile out(core::OutputFile::InMemory{"model"});
    pm::build(mesh::Mesh(mesh), options, out, "mesh");
    const core::InputFile file = out.read_back();
    return {file.bytes().begin(), file.bytes().end()};
}

pm::Model build_model(const mesh::Mesh& mesh, const pm::BuildOptions& options) {
    return pm::Model(memory_file(build_bytes(mesh, options)));
}

Bytes repaired(Bytes bytes) {
    if (bytes.size() < pm::kHeaderSize) return bytes;
    const uint64_t content = XXH3_64bits(bytes.data() + pm::kHeaderSize, bytes.size() - pm::kHeaderSize);
    std::memcpy(bytes.data() + 128, &content, 8);
    const uint64_t sum = XXH3_64bits(bytes.data(), pm::kHeaderSize - 8);
    std::memcpy(bytes.data() + pm::kHeaderSize - 8, &sum, 8);
    return bytes;
}

std::string fault_of(const Bytes& bytes, const std::function<void(const pm::Model&)>& use) {
    try {
        use(pm::Model(memory_file(bytes)));
        return "";
    } catch (const core::Error& error) {
        const std::string what = error.what();
        return what.substr(what.find(": ") + 2);  // without the file's name
    }
}

pm::BuildOptions lossless() {
    pm::BuildOptions options;
    options.bits = 0;
    return options;
}

namespace {

template <class Corner>
std::array<Corner, 3> turned(const Corner& a, const Corner& b, const Corner& c) {
    return std::min(
        {std::array<Corner, 3>{a, b, c}, std::array<Corner, 3>{b, c, a}, std::array<Corner, 3>{c, a, b}});
}

}  // namespace

Faces sorted(const std::vector<glm::u32vec3>& faces) {
    Faces list;
    for (const glm::u32vec3& f : faces) list.push_back(turned(f.x, f.y, f.z));
    std::sort(list.begin(), list.end());
    return list;
}

PlacedFaces placed(const mesh::Mesh& mesh) {
    PlacedFaces list;
    const auto place = [&](uint32_t v) {
        const glm::vec3 p = mesh.positions[v];
        return std::array<float, 3>{p.x, p.y, p.z};
    };
    for (const glm::u32vec3& f : mesh.triangles) list.push_back(turned(place(f.x), place(f.y), place(f.z)));
    std::sort(list.begin(), list.end());
    return list;
}

mesh::Mesh without_duplicates(mesh::Mesh mesh) {
    Faces faces = sorted(mesh.triangles);
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    mesh.triangles.clear();
    for (const auto& f : faces) mesh.triangles.emplace_back(f[0], f[1], f[2]);
    return mesh;
}

mesh::Mesh one_triangle() {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

mesh::Mesh bow_tie() {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 5, 4}, {0, 4, 6}, {0, 6, 5}, {4, 5, 6}};
    return mesh;
}

mesh::Mesh book(int pages) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}};
    for (int p = 0; p < pages; ++p) {
        const double angle = 6.28 * p / pages;
        mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.5);
        const auto v = uint32_t(2 + p);
        mesh.triangles.push_back(p % 2 ? glm::u32vec3(0, 1, v) : glm::u32vec3(1, 0, v));
    }
    return mesh;
}

mesh::Mesh strip(int triangles) {
    mesh::Mesh mesh;
    for (int v = 0; v < triangles + 2; ++v) mesh.positions.emplace_back(v / 2, v % 2, 0.01 * (v % 7));
    for (uint32_t t = 0; t < uint32_t(triangles); ++t)
        mesh.triangles.push_back(t % 2 ? glm::u32vec3(t + 1, t, t + 2) : glm::u32vec3(t, t + 1, t + 2));
    return mesh;
}

mesh::Mesh hub(int spokes) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}};
    for (int s = 0; s < spokes; ++s) {
        const double angle = 6.283185307179586 * s / spokes;
        mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
        mesh.triangles.emplace_back(0, 1 + s, 1 + (s + 1) % spokes);
    }
    return mesh;
}

// Two closed surfaces that touch along the edge of vertices 0 and 1 only.
mesh::Mesh two_sheets() {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}};
    mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 2, 3}, {1, 3, 2}, {1, 0, 4}, {0, 1, 5}, {0, 4, 5}, {1, 5, 4}};
    // And a bridge, by which the faces about vertex 0 and those about vertex 1 hang together.
    mesh.positions.emplace_back(0, 3, 0);
    mesh.triangles.insert(mesh.triangles.end(), {{0, 2, 6}, {0, 6, 4}, {1, 2, 6}, {1, 6, 4}});
    return mesh;
}

mesh::Mesh crossed_sheets(int across) {
    mesh::Mesh mesh;
    std::vector<uint32_t> row[2];  // by grid: the vertices of the one before
    for (int y = 0; y <= across; ++y) {
        const auto first = uint32_t(mesh.positions.size());
        for (int sheet = 0; sheet != 2; ++sheet) {
            std::vector<uint32_t> next;
            for (int x = 0; x <= across; ++x) {
                if (sheet == 1 && x == across / 2) {
                    next.push_back(first + uint32_t(x));
                    continue;
                }
                next.push_back(uint32_t(mesh.positions.size()));
                const float along = float(x - across / 2);
                const float off = x == across / 2 ? 0 : 0.3f * std::sin(0.7f * float(x + 2 * y));
                mesh.positions.push_back(sheet == 0 ? glm::vec3(along, y, off) : glm::vec3(off, y, along));
            }
            for (size_t x = 0; y > 0 && x != size_t(across); ++x) {
                mesh.triangles.emplace_back(row[sheet][x], row[sheet][x + 1], next[x]);
                mesh.triangles.emplace_back(row[sheet][x + 1], next[x + 1], next[x]);
            }
            row[sheet] = std::move(next);
        }
    }
    return mesh;
}

// Closed but for a triangle: its boundary is a loop of three edges.
mesh::Mesh pierced_ball() {
    mesh::Mesh mesh = splat_test::icosphere(2);
    mesh.triangles.pop_back();
    return mesh;
}

std::vector<NamedMesh> all_shapes() {
    using namespace splat_test;
    mesh::Mesh equal = icosphere(1);
    std::fill(equal.positions.begin(), equal.positions.end(), glm::vec3(3, 4, 5));
    return {{"tetrahedron", tetrahedron()},
            {"one triangle", one_triangle()},
            {"two triangles", two_triangles()},
            {"icosphere", icosphere(2)},
            {"a hole of three", pierced_ball()},
            {"torus", bumpy_torus(12, 30, true)},
            {"terrain", terrain(15)},
            {"needles", needle_fan(40)},
            {"duplicates", with_duplicates()},
            {"soup", soup(60)},
            {"moebius", moebius_strip(21)},
            {"mixed scales", mixed_scales()},
            {"bow-tie", bow_tie()},
            {"book", book(7)},
            {"strip", strip(80)},
            {"hub", hub(70)},
            {"two sheets", two_sheets()},
            {"crossed sheets", crossed_sheets(12)},
            {"all points equal", equal},
            {"far away", shifted(icosphere(2), {1e9, -1e9, 1e9})}};
}

}  // namespace pm_test
