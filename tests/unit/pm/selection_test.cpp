#include "pm/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "pm/front.h"
#include "test_models.h"

namespace {

using namespace pm_test;

// Somewhere about a unit box that was moved to `centre` and made `size` large, looking at it or past it.
pm::View random_view(Random& random, const glm::dvec3& centre, double size) {
    geom::Camera camera;
    camera.eye = centre + random.direction() * size * (0.1 + 3 * random.unit());
    camera.target = centre + random.direction() * size * random.unit() * 0.7;
    camera.up = random.direction();
    camera.fovy_deg = 10 + 100 * random.unit();
    return pm::make_view(geom::make_view(camera, 320, 240), 0.2 + 8 * random.unit());
}

std::vector<mesh::Mesh> meshes() {
    return {splat_test::icosphere(3), splat_test::bumpy_torus(24, 60), splat_test::terrain(20),
            splat_test::mixed_scales()};
}

glm::dvec3 centre_of(const pm::Model& model) {
    return model.header().placement.world_from_unit(glm::dvec3(0.5));
}

TEST(Selection, IsTheDefinitionDetailByDetail) {
    Random random(21);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::Model model = build_model(mesh);
        const pm::Hierarchy tree = model.hierarchy();
        pm::Selection selection(model);
        for (int round = 0; round < 60; ++round) {
            const pm::View view = random_view(random, centre_of(model), model.header().placement.extent);
            const pm::RefinementTest test(view, model.header().placement);
            std::vector<uint8_t> is_wanted(model.details());
            std::vector<uint32_t> wanted;
            for (uint32_t d = 0; d < model.details(); ++d) {
                const bool rests = (tree.parent[d] == pm::kNone || is_wanted[tree.parent[d]]) &&
                                   (tree.needs[d] == pm::kNone || is_wanted[tree.needs[d]]);
                is_wanted[d] = rests && test(model.bounds(d)) == pm::Verdict::refine;
                if (is_wanted[d]) wanted.push_back(d);
            }
            ASSERT_EQ(selection.select(view), wanted);
        }
    }
}

TEST(Selection, IsClosedAndAFrontCanTakeIt) {
    Random random(22);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::Model model = build_model(mesh);
        pm::Selection selection(model);
        for (int round = 0; round < 40; ++round) {
            pm::Front front(model.hierarchy());
            for (const uint32_t d :
                 selection.select(random_view(random, centre_of(model), model.header().placement.extent))) {
                ASSERT_TRUE(front.can_split(d));
                front.split(d);
            }
        }
    }
}

TEST(Selection, GrowsAsTheToleranceFalls) {
    Random random(23);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::Model model = build_model(mesh);
        pm::Selection selection(model);
        for (int round = 0; round < 40; ++round) {
            pm::View view = random_view(random, centre_of(model), model.header().placement.extent);
            std::vector<uint32_t> coarser = selection.select(view);
            for (const double factor : {0.7, 0.3, 0.01, 0.0}) {
                view.tolerance *= factor;
                const std::vector<uint32_t> finer = selection.select(view);
                ASSERT_TRUE(std::includes(finer.begin(), finer.end(), coarser.begin(), coarser.end()));
                coarser = finer;
            }
        }
    }
}

// What may be left coarse of the input at tolerance 0: faces that are outside of the picture, or show their
// backs.
TEST(Selection, LosesNothingThatCanBeSeen) {
    Random random(24);
    uint64_t seen = 0, left = 0;
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::Model model = build_model(mesh);
        pm::Front full(model.hierarchy());
        for (uint32_t d = 0; d < model.details(); ++d) full.split(d);
        const auto faces = full.faces();
        pm::Selection selection(model);
        for (int round = 0; round < 30; ++round) {
            pm::View view = random_view(random, centre_of(model), model.header().placement.extent);
            view.tolerance = 0;
            pm::Front front(model.hierarchy());
            front.assign(selection.select(view));
            left += model.details() - front.split_count();
            for (const glm::u32vec3& f : faces) {
                const bool is_there =
                    front.active(f.x) == f.x && front.active(f.y) == f.y && front.active(f.z) == f.z;
                if (is_there) continue;
                const glm::dvec3 p[3] = {model.world(f.x) - view.eye, model.world(f.y) - view.eye,
                                         model.world(f.z) - view.eye};
                const bool is_back = !(model.header().flags & pm::kOpenSurface) &&
                                     glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), p[0]) >= 0;
                const auto is_beyond = [&](const auto& side) {
                    return std::all_of(p, p + 3, [&](const glm::dvec3& q) { return side(q) < 1e-9; });
                };
                const auto depth = [&](const glm::dvec3& q) { return glm::dot(q, view.forward); };
                const bool is_outside = is_beyond([&](const glm::dvec3& q) {
                                            return glm::dot(q, view.right) - view.low.x * depth(q);
                                        }) ||
                                        is_beyond([&](const glm::dvec3& q) {
                                            return view.high.x * depth(q) - glm::dot(q, view.right);
                                        }) ||
                                        is_beyond([&](const glm::dvec3& q) {
                                            return glm::dot(q, view.down) - view.low.y * depth(q);
                                        }) ||
                                        is_beyond([&](const glm::dvec3& q) {
                                            return view.high.y * depth(q) - glm::dot(q, view.down);
                                        });
                const bool has_area = glm::cross(p[1] - p[0], p[2] - p[0]) != glm::dvec3(0);
                ASSERT_TRUE(is_back || is_outside || !has_area);
                ++seen;
            }
        }
    }
    EXPECT_GT(left, 10000u);  // something was left out
    EXPECT_GT(seen, 1000u);
}

TEST(Selection, DoesNotDependOnScaleOrPlace) {
    const mesh::Mesh mesh = splat_test::bumpy_torus(24, 60);
    const pm::Model one = build_model(mesh);
    Random random(25);
    for (const int exponent : {-100, 100}) {
        const double scale = std::exp2(exponent);
        const pm::Model other = build_model(splat_test::scaled(mesh, scale));
        for (int round = 0; round < 20; ++round) {
            pm::View view = random_view(random, centre_of(one), one.header().placement.extent);
            const std::vector<uint32_t> expected = pm::Selection(one).select(view);
            view.eye *= scale;
            EXPECT_EQ(pm::Selection(other).select(view), expected);
        }
    }
}

TEST(Selection, RefinesWhereAViewIsNotANumber) {
    const pm::Model model = build_model(splat_test::icosphere(2));
    pm::View view;
    view.eye.x = std::nan("");
    view.tolerance = 1;
    EXPECT_EQ(pm::Selection(model).select(view).size(), model.details());
    EXPECT_THROW(pm::check(view), core::Error);
}

TEST(View, IsCheckedBeforeItIsUsed) {
    const auto is_refused = [](const auto& change) {
        pm::View view;
        change(view);
        try {
            pm::check(view);
            return false;
        } catch (const core::Error&) {
            return true;
        }
    };
    EXPECT_FALSE(is_refused([](pm::View&) {}));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.eye.x = 1e151; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.right = v.down; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.forward *= 1.001; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.low.x = v.high.x; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.high.y = 1e7; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.tolerance = -1; }));
    EXPECT_TRUE(is_refused([](pm::View& v) { v.tolerance = INFINITY; }));
}

}  // namespace
