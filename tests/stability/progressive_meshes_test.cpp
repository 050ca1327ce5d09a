// Progressive meshes of what breaks simplifiers: planes, lines and points, slivers, extreme scales and
// places.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "mesh/distance.h"
#include "pm/build.h"
#include "pm/extract.h"
#include "pm/selection.h"
#include "pm/verify.h"
#include "shapes.h"
#include "table.h"

namespace stability {
namespace {

struct Input {
    std::string name;
    Shape shape;
    Precision precision = Precision::single;
};

std::ostream& operator<<(std::ostream& out, const Input& input) {
    return out << input.name;
}

Shape mapped(Shape shape, const std::function<glm::dvec3(const glm::dvec3&)>& map) {
    for (glm::dvec3& v : shape.vertices) v = map(v);
    return shape;
}

Shape many(const Shape& shape, int count) {
    Shape all;
    for (int i = 0; i < count; ++i) all = joined(std::move(all), placed(shape, 1, glm::dvec3(3 * i, 0, 0)));
    return all;
}

std::vector<Input> inputs() {
    const Shape ball = bumpy_sphere(), ground = terrain(2);
    const auto flat = mapped(ground, [](const glm::dvec3& v) { return glm::dvec3(v.x, 0, v.z); });
    const auto tilted =
        mapped(ground, [](const glm::dvec3& v) { return glm::dvec3(v.x, v.x / 3 + v.z / 7, v.z); });
    const auto line = mapped(ground, [](const glm::dvec3& v) { return glm::dvec3(v.x, v.x, v.x); });
    const auto point = mapped(ground, [](const glm::dvec3&) { return glm::dvec3(4, 5, 6); });
    const auto thin = mapped(ball, [](const glm::dvec3& v) { return glm::dvec3(v.x, 1e-9 * v.y, v.z); });
    std::vector<Input> list{{"a plane", flat},
                            {"a tilted plane", tilted},
                            {"a line", line},
                            {"a point", point},
                            {"flat by 1e-9", thin},
                            {"slivers, aspect 1e6", slivers(2000, 1e6)},
                            {"spacing 2^-k, k to 60", halving_spacing(60)},
                            {"151 tetrahedra", many(tetrahedron(), 151)},
                            {"small by far", joined(placed(ball, 1e-6, {0, 2e4, 0}), terrain(1e4))}};
    for (const double scale : {1e-30, 1e-12, 1e12, 1e30}) {
        char name[40];
        std::snprintf(name, sizeof(name), "scale %.0e", scale);
        list.push_back({name, placed(ball, scale, glm::dvec3(0))});
    }
    list.push_back({"at 1e9, double", placed(ball, 1, glm::dvec3(1e9, -1e9, 1e9)), Precision::twice});
    list.push_back({"at 1e12, double", placed(ball, 1, glm::dvec3(1e12)), Precision::twice});
    return list;
}

struct Built {
    mesh::Mesh mesh;
    std::unique_ptr<pm::Model> model;
    pm::BuildReport report;
};

Built build_model(const Input& input, const pm::BuildOptions& options) {
    const std::string ply = to_ply(input.shape, input.precision);
    Built built;
    built.mesh = mesh::read_mesh_bytes(std::as_bytes(std::span(ply)), "shape.ply").mesh;
    core::OutputFile out(core::OutputFile::InMemory{"shape.pm"});
    built.report = pm::build(mesh::Mesh(built.mesh), options, out, "shape.ply");
    built.model = std::make_unique<pm::Model>(out.read_back());
    return built;
}

// The farthest vertex from the surface of another mesh, by `unit`.
double worst_distance(const mesh::Mesh& from, const mesh::Mesh& to, double unit) {
    const mesh::SurfaceDistance distance(to);
    double worst = 0;
    for (size_t v = 0; v < from.positions.size(); ++v)
        worst = std::max(worst, distance.distance(from.world(v), INFINITY) / unit);
    return worst;
}

class ProgressiveMesh : public testing::TestWithParam<Input> {};

TEST_P(ProgressiveMesh, IsTheRoundedInput) {
    const Built built = build_model(GetParam(), {});
    const pm::Header& h = built.model->header();
    EXPECT_NO_THROW(pm::verify(*built.model));
    const std::string row = "progressive mesh, " + GetParam().name;
    expect_at_most(row, "faces lost", double(built.mesh.triangles.size()) - double(h.faces), 0);
    const mesh::Mesh full = pm::mesh_of_level(*built.model, built.model->details());
    // Half of a step along each axis, and what world coordinates are rounded by, here and in the measure.
    const double step = h.placement.extent / h.steps();
    const double largest =
        glm::length(h.placement.origin) + glm::length(h.placement.low) + h.placement.extent;
    expect_at_most(row, "vertex off / step", worst_distance(built.mesh, full, step),
                   0.867 + largest * 0x1p-50 / step);
}

TEST_P(ProgressiveMesh, LosslessIsTheInput) {
    pm::BuildOptions options;
    options.bits = 0;
    const Built built = build_model(GetParam(), options);
    EXPECT_NO_THROW(pm::verify(*built.model));
    const mesh::Mesh full = pm::mesh_of_level(*built.model, built.model->details());
    auto sorted = [](const mesh::Mesh& mesh) {
        std::vector<std::array<float, 9>> faces;
        for (const glm::u32vec3& t : mesh.triangles) {
            std::array<std::array<float, 9>, 3> turns{};
            for (int turn = 0; turn < 3; ++turn)
                for (int k = 0; k < 9; ++k)
                    turns[size_t(turn)][size_t(k)] = mesh.positions[t[(turn + k / 3) % 3]][k % 3];
            faces.push_back(*std::min_element(turns.begin(), turns.end()));
        }
        std::sort(faces.begin(), faces.end());
        return faces;
    };
    EXPECT_EQ(sorted(full), sorted(built.mesh));
}

// Of all that is split in random order, how many faces are turned by more than 90 degrees from that of the
// input.
TEST_P(ProgressiveMesh, FoldsFewFacesAtRandomFronts) {
    const Built built = build_model(GetParam(), {});
    const pm::Model& model = *built.model;
    const pm::Hierarchy tree = model.hierarchy();
    std::mt19937_64 random(5);
    uint64_t folded = 0, all = 0;
    for (const double share : {0.1, 0.3, 0.6}) {
        pm::Front front(tree);
        while (front.split_count() < share * model.details()) {
            const auto d = uint32_t(random() % model.details());
            if (front.can_split(d)) front.split(d);
        }
        const auto look_at = [&](const glm::u32vec3& leaf) {
            if (leaf.x == pm::kNone) return;
            const auto normal = [&](const glm::u32vec3& v) {
                return glm::cross(model.unit(v.y) - model.unit(v.x), model.unit(v.z) - model.unit(v.x));
            };
            const glm::u32vec3 at(front.active(leaf.x), front.active(leaf.y), front.active(leaf.z));
            ++all, folded += glm::dot(normal(leaf), normal(at)) < 0;
        };
        for (const glm::u32vec3& face : tree.base_faces) look_at(face);
        for (uint32_t d = 0; d < tree.details(); ++d)
            if (front.is_split(d)) look_at(tree.faces[d].left), look_at(tree.faces[d].right);
    }
    expect_at_most("progressive mesh, " + GetParam().name, "folded faces / all", double(folded) / double(all),
                   0.05);
}

// Seen from where it fits the picture: how far the input is from the mesh that the view gets.
TEST_P(ProgressiveMesh, HoldsItsTolerance) {
    const Built built = build_model(GetParam(), {});
    const pm::Model& model = *built.model;
    const pm::Placement& at = model.header().placement;
    geom::Camera camera;
    camera.target = at.world_from_unit(glm::dvec3(0.5));
    camera.eye = camera.target + at.extent * glm::dvec3(1.2, 1.5, 1.6);
    camera.fovy_deg = 45;
    const pm::View view = pm::make_view(geom::make_view(camera, 400, 400), 1);
    pm::Front front(model.hierarchy());
    front.assign(pm::Selection(model).select(view));
    const mesh::Mesh seen = pm::mesh_of(model, front);
    const mesh::Mesh full = pm::mesh_of_level(model, model.details());
    // Errors are those of the worst leaf when a node was made; what is seen of a closed ball is not its back.
    std::vector<glm::vec3> facing;
    std::vector<glm::dvec3> normals(full.positions.size(), glm::dvec3(0));
    for (const glm::u32vec3& t : full.triangles) {
        const glm::dvec3 n =
            glm::cross(full.world(t.y) - full.world(t.x), full.world(t.z) - full.world(t.x)) /
            (at.extent * at.extent);
        for (int k = 0; k < 3; ++k) normals[t[k]] += n;
    }
    const mesh::SurfaceDistance distance(seen);
    double worst = 0;
    for (size_t v = 0; v < full.positions.size(); ++v) {
        const glm::dvec3 offset = full.world(v) - view.eye;
        const bool is_back = !(model.header().flags & pm::kOpenSurface) && glm::dot(normals[v], offset) >= 0;
        if (!is_back)
            worst = std::max(
                worst, distance.distance(full.world(v), INFINITY) / glm::length(offset) / view.tolerance);
    }
    expect_at_most("progressive mesh, " + GetParam().name, "error / tolerance", worst, 2.5);
}

INSTANTIATE_TEST_SUITE_P(Of, ProgressiveMesh, testing::ValuesIn(inputs()), [](const auto& row) {
    std::string name = row.param.name;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name + std::to_string(row.index);
});

}  // namespace
}  // namespace stability
