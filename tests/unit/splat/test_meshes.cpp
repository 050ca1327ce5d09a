#include "test_meshes.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include "splat/compress.h"
#include "splat/walk.h"

namespace splat_test {

namespace {

constexpr double kPi = std::numbers::pi;

// A grid of rows x columns vertices as triangles; closed ways round where told.
void add_grid(mesh::Mesh& mesh, int rows, int columns, bool is_closed) {
    const int last_row = is_closed ? rows : rows - 1, last_column = is_closed ? columns : columns - 1;
    const auto at = [&](int r, int c) { return uint32_t((r % rows) * columns + c % columns); };
    for (int r = 0; r < last_row; ++r)
        for (int c = 0; c < last_column; ++c) {
            mesh.triangles.emplace_back(at(r, c), at(r + 1, c), at(r + 1, c + 1));
            mesh.triangles.emplace_back(at(r, c), at(r + 1, c + 1), at(r, c + 1));
        }
}

}  // namespace

glm::dvec3 Random::direction() {
    const double z = 2 * unit() - 1, phi = 2 * kPi * unit(), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

mesh::Mesh tetrahedron() {
    mesh::Mesh m;
    m.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    m.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    return m;
}

mesh::Mesh two_triangles() {
    mesh::Mesh m;
    m.positions = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0.2f}, {0, 1, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

mesh::Mesh icosphere(int subdivisions) {
    mesh::Mesh m;
    const auto t = float((1 + std::sqrt(5.0)) / 2);
    m.positions = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    m.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                   {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                   {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int s = 0; s < subdivisions; ++s) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [it, is_new] =
                middles.try_emplace({std::min(a, b), std::max(a, b)}, uint32_t(m.positions.size()));
            if (is_new) m.positions.push_back(0.5f * (m.positions[a] + m.positions[b]));
            return it->second;
        };
        std::vector<glm::u32vec3> finer;
        for (const glm::u32vec3& f : m.triangles) {
            const uint32_t a = middle(f.x, f.y), b = middle(f.y, f.z), c = middle(f.z, f.x);
            finer.insert(finer.end(), {{f.x, a, c}, {f.y, b, a}, {f.z, c, b}, {a, b, c}});
        }
        m.triangles = finer;
    }
    for (glm::vec3& p : m.positions) p = glm::normalize(p);
    return m;
}

mesh::Mesh bumpy_torus(int around, int along, bool has_colours) {
    mesh::Mesh m;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double u = 2 * kPi * i / along, v = 2 * kPi * j / around;
            const double r =
                0.35 * (1 + 0.15 * std::sin(7 * u) * std::cos(5 * v) + 0.04 * std::sin(31 * u + 23 * v));
            const double ring = 1 + r * std::cos(v);
            m.positions.emplace_back(ring * std::cos(u), ring * std::sin(u), r * std::sin(v));
            if (has_colours)
                m.colours.emplace_back(uint8_t(127 + 120 * std::sin(u)), uint8_t(127 + 120 * std::sin(v)),
                                       uint8_t(i * 5 & 255));
        }
    add_grid(m, along, around, true);
    return m;
}

mesh::Mesh terrain(int side) {
    mesh::Mesh m;
    Random random(7);
    for (int r = 0; r < side; ++r)
        for (int c = 0; c < side; ++c) {
            const double x = double(c) / side, y = double(r) / side;
            const double z = 0.1 * std::sin(9 * x) * std::cos(7 * y) + 0.02 * random.unit() / side * 20;
            m.positions.emplace_back(x, y, z);
        }
    add_grid(m, side, side, false);
    return m;
}

mesh::Mesh needle_fan(int needles) {
    mesh::Mesh m;
    m.positions.emplace_back(0, 0, 0);
    for (int i = 0; i <= needles; ++i) {
        const double a = 1e-4 * i;
        m.positions.emplace_back(std::cos(a), std::sin(a), 0.1 * std::sin(300 * a));
    }
    for (uint32_t i = 1; i <= uint32_t(needles); ++i) m.triangles.emplace_back(0, i, i + 1);
    return m;
}

mesh::Mesh with_duplicates() {
    mesh::Mesh m = icosphere(3);
    const auto count = uint32_t(m.positions.size());
    const auto triangles = m.triangles;
    m.positions.insert(m.positions.end(), m.positions.begin(), m.positions.begin() + count);
    for (const glm::u32vec3& t : triangles) m.triangles.push_back(t + count);   // a second sheet
    m.triangles.insert(m.triangles.end(), triangles.begin(), triangles.end());  // each face again
    for (uint32_t i = 0; i < count; i += 9)
        m.triangles.emplace_back(i, i + count, (i + 1) % count);  // no area
    return m;
}

mesh::Mesh soup(int triangles) {
    mesh::Mesh m;
    Random random(5);
    for (int i = 0; i < triangles; ++i) {
        const glm::dvec3 at = random.direction() * random.unit();
        for (int k = 0; k < 3; ++k) m.positions.emplace_back(at + 0.3 * random.unit() * random.direction());
        m.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    return m;
}

mesh::Mesh moebius_strip(int along) {
    mesh::Mesh m;
    constexpr int kAcross = 5;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < kAcross; ++j) {
            const double u = 2 * kPi * i / along, w = 0.4 * (j / (kAcross - 1.0) - 0.5);
            const double r = 1 + w * std::cos(u / 2);
            m.positions.emplace_back(r * std::cos(u), r * std::sin(u), w * std::sin(u / 2));
        }
    add_grid(m, along, kAcross, false);
    const auto last = uint32_t((along - 1) * kAcross);
    for (uint32_t j = 0; j + 1 < kAcross; ++j) {  // the last row meets the first, turned over
        m.triangles.emplace_back(last + j, kAcross - 1 - j, kAcross - 2 - j);
        m.triangles.emplace_back(last + j, kAcross - 2 - j, last + j + 1);
    }
    return m;
}

mesh::Mesh mixed_scales() {
    mesh::Mesh m = terrain(40);
    const mesh::Mesh ball = icosphere(3);
    for (const glm::vec3& at : {glm::vec3(0.5f, 0.5f, 0.2f), glm::vec3(3, 3, 3)}) {
        const auto first = uint32_t(m.positions.size());
        for (const glm::vec3& p : ball.positions) m.positions.push_back(at + 1e-4f * p);
        for (const glm::u32vec3& t : ball.triangles) m.triangles.push_back(t + first);
    }
    return m;
}

mesh::Mesh scaled(mesh::Mesh mesh, double by) {
    for (glm::vec3& p : mesh.positions) p = glm::vec3(by * glm::dvec3(p));
    return mesh;
}

mesh::Mesh cloud(int points) {
    mesh::Mesh m;
    Random random(11);
    for (int i = 0; i < points; ++i)
        m.positions.emplace_back(random.direction() * (1 + 0.05 * random.unit()));
    return m;
}

mesh::Mesh shifted(mesh::Mesh mesh, const glm::dvec3& by) {
    mesh.origin += by;
    return mesh;
}

std::vector<NamedMesh> generated_meshes() {
    std::vector<NamedMesh> meshes;
    meshes.push_back({"tetrahedron", tetrahedron()});
    meshes.push_back({"two triangles", two_triangles()});
    meshes.push_back({"icosphere", icosphere(4)});
    meshes.push_back({"bumpy torus", bumpy_torus(60, 160)});
    meshes.push_back({"terrain", terrain(80)});
    meshes.push_back({"needle fan", needle_fan(1000)});
    meshes.push_back({"duplicates", with_duplicates()});
    meshes.push_back({"far torus", shifted(bumpy_torus(30, 60), {4e5, 5e6, 100})});
    meshes.push_back({"soup", soup(300)});
    meshes.push_back({"moebius strip", moebius_strip(80)});
    meshes.push_back({"mixed scales", mixed_scales()});
    meshes.push_back({"small torus", scaled(bumpy_torus(30, 60), 1e-25)});
    meshes.push_back({"large torus", scaled(bumpy_torus(30, 60), 1e25)});
    return meshes;
}

mesh::Mesh shared_mesh(const std::string& file) {
    const std::string path = std::string(QS_SHARED_DATA) + "/" + file;
    if (!std::filesystem::exists(path)) return {};
    return mesh::read_mesh(path).mesh;
}

Bytes read_bytes(const std::string& path) {
    const core::InputFile file(path);
    return {file.bytes().begin(), file.bytes().end()};
}

Bytes compressed(const Bytes& plain) {
    const splat::Model model(memory_file(plain));
    core::OutputFile out(core::OutputFile::InMemory{"out"});
    splat::write_compressed(splat::plain_of(model), out);
    const core::InputFile file = out.read_back();
    return {file.bytes().begin(), file.bytes().end()};
}

Bytes build_bytes(mesh::Mesh mesh, const splat::BuildOptions& options, splat::BuildReport* report) {
    char folder[] = "/tmp/splat-test-XXXXXX";
    if (!::mkdtemp(folder)) std::abort();
    const std::string path = std::string(folder) + "/model.qs";
    {
        core::OutputFile out(path);
        const splat::BuildReport r = splat::build(std::move(mesh), options, out, "test");
        if (report) *report = r;
        out.commit();
    }
    Bytes bytes = read_bytes(path);
    std::filesystem::remove_all(folder);
    return bytes;
}

splat::Model build_model(mesh::Mesh mesh, const splat::BuildOptions& options) {
    return open_model(build_bytes(std::move(mesh), options));
}

Tree read_tree(const splat::Model& model) {
    Tree tree;
    const auto add = [&](const splat::Node& node, uint32_t level) {
        tree.nodes.push_back(node);
        tree.level.push_back(level);
        tree.first_child.push_back(0);
        tree.parent.push_back(0);
    };
    add(model.root(), 0);
    splat::walk(model, splat::kMaxLevels, [&](const splat::WalkedNode& n) { add(n.node, n.level); });
    uint32_t next = 1;
    for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
        tree.first_child[i] = next;
        for (int k = 0; k < tree.nodes[i].children && next < tree.nodes.size(); ++k) tree.parent[next++] = i;
    }
    return tree;
}

bool is_inside(const splat::Node& node, const glm::dvec3& p, double tolerance) {
    const glm::dvec3 d = p - node.centre, n(node.normal);
    const double along = glm::dot(n, d) / glm::length(n);
    const double across = std::max(0.0, glm::dot(d, d) - along * along);
    const double w = along / double(node.flatness);
    return std::sqrt(across + w * w) <= double(node.radius) * (1 + tolerance);
}

}  // namespace splat_test
