// The walk that draws decodes by SIMD in single precision; here it is held against decode_node().
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/cut.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

// x y z, normal x y z, radius, flatness; view space, model units.
using Splat = std::array<double, 8>;

std::vector<Splat> splats_of_cut(const splat::Model& model, const geom::View& view) {
    splat::Cut cut(model);
    splat::CutOptions options;
    options.threshold_px = 0;
    options.cull_backfaces = false;
    std::vector<Splat> splats;
    const size_t tasks = cut.begin(view, options);
    for (size_t t = 0; t < tasks; ++t)
        cut.run(t, [&](const geom::SplatBatch& b) {
            for (int i = 0; i < b.count; ++i)
                splats.push_back({double(b.x[i]), double(b.y[i]), double(b.z[i]), double(b.nx[i]),
                                  double(b.ny[i]), double(b.nz[i]), double(b.radius[i]),
                                  double(b.flatness[i])});
        });
    EXPECT_EQ(cut.counts().nodes_visited, model.header().node_count);
    EXPECT_EQ(cut.counts().splats, model.header().leaf_count);
    return splats;
}

std::vector<Splat> splats_of_leaves(const splat::Model& model, const geom::View& view) {
    std::vector<Splat> splats;
    for (const splat::Node& node : read_tree(model).nodes) {
        if (node.children > 0) continue;
        const glm::dvec3 at =
            view.view_from_world(model.header().origin + model.header().scale * node.centre) /
            model.header().scale;
        const glm::dvec3 n(node.normal);
        splats.push_back({at.x, at.y, at.z, glm::dot(view.right, n), glm::dot(view.down, n),
                          glm::dot(view.forward, n), double(node.radius), double(node.flatness)});
    }
    return splats;
}

// Largest difference of any of the eight numbers when each splat is paired with one of the others.
double difference(std::vector<Splat> a, std::vector<Splat> b) {
    constexpr double kNear = 1e-5;
    if (a.size() != b.size()) return 1e300;
    std::sort(a.begin(), a.end());
    double worst = 0;
    for (const Splat& s : b) {
        auto best = a.end();
        double least = 1e300;
        const auto first = std::lower_bound(a.begin(), a.end(), s[0] - kNear,
                                            [](const Splat& x, double v) { return x[0] < v; });
        for (auto it = first; it != a.end() && (*it)[0] <= s[0] + kNear; ++it) {
            double most = 0;
            for (size_t k = 0; k < s.size(); ++k) most = std::max(most, std::fabs((*it)[k] - s[k]));
            if (most < least) least = most, best = it;
        }
        if (best == a.end()) return 1e300;
        worst = std::max(worst, least);
    }
    return worst;
}

void expect_same(const std::string& name, const mesh::Mesh& mesh) {
    const splat::Model model = build_model(mesh);
    const splat::Header& h = model.header();
    geom::Camera camera;
    camera.eye = h.origin + h.scale * glm::dvec3(1.5, 2.0, 3.5);
    camera.target = h.origin;
    camera.fovy_deg = 60;
    const geom::View view = geom::make_view(camera, 512, 512);
    EXPECT_LT(difference(splats_of_leaves(model, view), splats_of_cut(model, view)), 1e-6) << name;
}

}  // namespace

TEST(Cut, DecodesAsTheNodeCodeSays) {
    for (const NamedMesh& m : generated_meshes()) expect_same(m.name, m.mesh);
}

TEST(Cut, DecodesTheBunnyAsTheNodeCodeSays) {
    const mesh::Mesh mesh = shared_mesh("bunny.ply");
    if (mesh.positions.empty()) GTEST_SKIP() << "bunny.ply is not there";
    expect_same("bunny", mesh);
}
