// Occlusion culling: it leaves things out, and no pixel tells.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "core/parallel.h"
#include "scene/draw.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

constexpr int kWidth = 640, kHeight = 480;

mesh::Mesh joined(const std::vector<mesh::Mesh>& parts) {
    mesh::Mesh all;
    for (const mesh::Mesh& part : parts) {
        const glm::u32vec3 first(uint32_t(all.positions.size()));
        all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
        for (const glm::u32vec3& t : part.triangles) all.triangles.push_back(t + first);
    }
    return all;
}

// Without every n-th face.
mesh::Mesh with_holes(mesh::Mesh mesh, size_t n) {
    std::vector<glm::u32vec3> kept;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        if (i % n != 0) kept.push_back(mesh.triangles[i]);
    mesh.triangles = kept;
    return mesh;
}

// Balls in each other, each of another colour, so that none shows through another unseen.
mesh::Mesh onion(const std::vector<mesh::Mesh>& skins) {
    mesh::Mesh all = joined(skins);
    all.colours.clear();
    for (size_t k = 0; k < skins.size(); ++k)
        all.colours.insert(all.colours.end(), skins[k].positions.size(),
                           glm::u8vec3(k == 0 ? 255 : 30, 120 * k, 200));
    return all;
}

struct Subject {
    const char* name;
    mesh::Mesh mesh;
    bool hides;  // surely, most of it
};

std::vector<Subject> subjects() {
    const mesh::Mesh ball = icosphere(6);
    return {{"onion", onion({ball, scaled(icosphere(5), 0.8), scaled(icosphere(5), 0.4)}), true},
            {"onion with close skins", onion({ball, scaled(ball, 0.98)}), false},
            {"onion with holes", onion({with_holes(ball, 7), scaled(icosphere(5), 0.9)}), true},
            {"torus", bumpy_torus(120, 320, true), false},
            {"terrain", terrain(200), false},
            {"soup", soup(3000), false}};
}

std::vector<geom::View> views_of(const splat::Model& model, const mesh::Mesh& mesh) {
    std::vector<geom::View> views = random_views(model, mesh, 5);
    for (geom::View& view : views) {
        view.focal_px *= double(kHeight) / view.height;
        view.width = kWidth, view.height = kHeight;
    }
    views.push_back(fitted_view(model, kWidth, kHeight));
    views.push_back(fitted_view(model, 333, 251));  // no whole blocks
    return views;
}

Drawn draw(scene::ModelPainter& painter, const geom::View& view, scene::DrawOptions options,
           scene::Occlusion occlusion) {
    Drawn drawn;
    options.occlusion = occlusion;
    drawn.report = painter.draw(view, options, drawn.frame);
    return drawn;
}

std::vector<scene::DrawOptions> options_for(size_t view) {
    std::vector<scene::DrawOptions> all;
    for (const render::SplatKind kind : {render::SplatKind::square, render::SplatKind::circle,
                                         render::SplatKind::ellipse, render::SplatKind::smooth}) {
        scene::DrawOptions options;
        options.kind = kind;
        options.cut.cull_backfaces = view % 2 == 0;
        options.cut.threshold_px = view % 3 == 0 ? 0.3 : 1;
        options.look.shade = view % 2 == 0 ? render::Shade::lit : render::Shade::flat;
        all.push_back(options);
    }
    return all;
}

}  // namespace

TEST(Occlusion, ChangesNoPixel) {
    for (const Subject& subject : subjects()) {
        const splat::Model model = build_model(subject.mesh);
        scene::ModelPainter painter(model);
        uint64_t all = 0, some = 0, hidden = 0;
        const std::vector<geom::View> views = views_of(model, subject.mesh);
        for (size_t v = 0; v < views.size(); ++v) {
            for (const scene::DrawOptions& options : options_for(v)) {
                const Drawn off = draw(painter, views[v], options, scene::Occlusion::off);
                const Drawn on = draw(painter, views[v], options, scene::Occlusion::on);
                ASSERT_EQ(off.frame.rgb, on.frame.rgb) << subject.name << ", view " << v;
                ASSERT_EQ(off.frame.depth, on.frame.depth) << subject.name << ", view " << v;
                EXPECT_EQ(off.report.counts.occlusion_culled, 0u);
                all += off.report.counts.splats, some += on.report.counts.splats;
                hidden += on.report.counts.occlusion_culled;
            }
        }
        if (!subject.hides) continue;
        EXPECT_GT(hidden, 0u) << subject.name;
        EXPECT_LT(some, all) << subject.name;
    }
}

TEST(Occlusion, ChangesNoPixelBesideTriangles) {
    for (const Subject& subject : subjects()) {
        const splat::Model model = build_model(subject.mesh, {.leaf = splat::Leaf::triangle});
        scene::ModelPainter painter(model);
        uint64_t hidden = 0, triangles = 0, splats = 0;
        const std::vector<geom::View> views = views_of(model, subject.mesh);
        for (size_t v = 0; v < views.size(); ++v) {
            for (scene::DrawOptions options : options_for(v)) {
                // All leaves, some, and those that are large.
                options.cut.triangle_px = v % 3 == 0 ? 0 : v % 3 == 1 ? 4 : 12;
                const Drawn off = draw(painter, views[v], options, scene::Occlusion::off);
                const Drawn on = draw(painter, views[v], options, scene::Occlusion::on);
                ASSERT_EQ(off.frame.rgb, on.frame.rgb) << subject.name << ", view " << v;
                ASSERT_EQ(off.frame.depth, on.frame.depth) << subject.name << ", view " << v;
                hidden += on.report.counts.occlusion_culled;
                triangles += on.report.counts.triangles, splats += on.report.counts.splats;
            }
        }
        EXPECT_GT(triangles, 0u) << subject.name;
        EXPECT_GT(splats, 0u) << subject.name;
        EXPECT_TRUE(hidden > 0 || !subject.hides) << subject.name;
    }
}

TEST(Occlusion, ChangesNoPixelBetweenNearAndFar) {
    const mesh::Mesh mesh = onion({icosphere(6), scaled(icosphere(5), 0.7)});
    const splat::Model model = build_model(mesh);
    scene::ModelPainter painter(model);
    for (const double near : {2.5, 3.2, 3.5, 4.0}) {
        geom::View view = fitted_view(model, kWidth, kHeight);
        view.near = near * model.header().scale, view.far = 4.3 * model.header().scale;
        const Drawn off = draw(painter, view, {}, scene::Occlusion::off);
        const Drawn on = draw(painter, view, {}, scene::Occlusion::on);
        EXPECT_EQ(off.frame.rgb, on.frame.rgb) << near;
        EXPECT_EQ(off.frame.depth, on.frame.depth) << near;
    }
}

TEST(Occlusion, ChangesNoPixelOfAPartOfAPicture) {
    const mesh::Mesh mesh = onion({with_holes(icosphere(6), 7), scaled(icosphere(5), 0.9)});
    const splat::Model model = build_model(mesh);
    scene::ModelPainter painter(model);
    const geom::View whole = fitted_view(model, kWidth, kHeight);
    for (const glm::ivec4& part : {glm::ivec4(101, 77, 333, 211), {320, 0, 1, 480}, {5, 240, 630, 3}}) {
        const geom::View view = geom::part_of(whole, part.x, part.y, part.z, part.w);
        const Drawn off = draw(painter, view, {}, scene::Occlusion::off);
        const Drawn on = draw(painter, view, {}, scene::Occlusion::on);
        EXPECT_EQ(off.frame.rgb, on.frame.rgb);
        EXPECT_EQ(off.frame.depth, on.frame.depth);
    }
}

TEST(Occlusion, ChangesNoPixelOfTheSmallTheLargeTheCloseAndTheFarAway) {
    const mesh::Mesh mesh = onion({with_holes(icosphere(5), 7), scaled(icosphere(5), 0.9)});
    for (const double scale : {1e-25, 1.0, 1e20}) {
        const mesh::Mesh there = scaled(mesh, scale);
        const splat::Model model = build_model(there);
        scene::ModelPainter painter(model);
        std::vector<geom::View> views = close_views(model, there, 6);
        geom::Camera camera;
        camera.target = model.header().origin;
        for (const double distance : {0.0, 0.85, 1e3, 1e6, 1e9}) {
            camera.eye = camera.target + scale * (distance + 0.01) * glm::normalize(glm::dvec3(1, 2, 3));
            camera.fovy_deg = distance < 2 ? 120 : 60 / distance;
            views.push_back(geom::make_view(camera, kWidth, kHeight));
        }
        for (size_t v = 0; v < views.size(); ++v) {
            const Drawn off = draw(painter, views[v], {}, scene::Occlusion::off);
            const Drawn on = draw(painter, views[v], {}, scene::Occlusion::on);
            EXPECT_EQ(off.frame.rgb, on.frame.rgb) << scale << ", view " << v;
            EXPECT_EQ(off.frame.depth, on.frame.depth) << scale << ", view " << v;
        }
    }
}

TEST(Occlusion, LeavesOutMostOfWhatIsInsideAndKeepsTheBound) {
    const splat::Model model =
        build_model(onion({icosphere(6), scaled(icosphere(6), 0.8), scaled(icosphere(6), 0.6)}));
    scene::ModelPainter painter(model);
    const geom::View view = fitted_view(model, 1280, 960);
    const Drawn off = draw(painter, view, {}, scene::Occlusion::off);
    const Drawn on = draw(painter, view, {}, scene::Occlusion::automatic);
    EXPECT_EQ(off.frame.rgb, on.frame.rgb);
    EXPECT_LT(double(on.report.counts.splats), 0.5 * double(off.report.counts.splats));
    EXPECT_LE(on.report.counts.error_bound_px, off.report.counts.error_bound_px);
    EXPECT_LT(on.report.counts.blocks_touched, off.report.counts.blocks_touched);
}

TEST(Occlusion, SwitchesItselfOffWhereNothingIsHidden) {
    const splat::Model model = build_model(icosphere(6));
    scene::ModelPainter painter(model);
    const geom::View view = fitted_view(model, 1280, 960);
    const Drawn off = draw(painter, view, {}, scene::Occlusion::off);
    const Drawn on = draw(painter, view, {}, scene::Occlusion::automatic);
    EXPECT_EQ(on.report.counts.occlusion_culled, 0u);
    EXPECT_EQ(on.report.counts.splats, off.report.counts.splats);
    EXPECT_EQ(on.report.counts.nodes_visited, off.report.counts.nodes_visited) << "levels are walked once";
}

TEST(Occlusion, LooksAtManySpheresAsAtEach) {
    using Map = geom::OcclusionMap;
    geom::Camera camera;
    camera.eye = {0, 0, 0}, camera.target = {0, 0, -1};
    Map map;
    map.begin(geom::make_view(camera, kWidth, kHeight), 1);
    std::vector<Map::Surface> wall;  // over the picture's left half
    for (int y = -20; y <= 20; ++y)
        for (int x = -40; x <= 0; ++x)
            wall.push_back({{0.1f * float(x), 0.1f * float(y), 4}, 0.1f, {0, 0, -1}, 0.001f});
    map.add_surfaces(wall);
    map.build();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    size_t found[3] = {};
    for (int round = 0; round < 20; ++round) {
        Map::Spheres many;
        while (many.count < Map::Spheres::kCapacity - size_t(round)) {
            const float z = std::exp(6 * unit(random) - 2);
            many.add({(2 * unit(random) - 1) * 0.5f * z, (2 * unit(random) - 1) * 0.3f * z, z},
                     z * std::exp(-8 * unit(random)));
        }
        Map::Sight sights[Map::Spheres::kCapacity];
        map.look(many, sights);
        for (size_t i = 0; i < many.count; ++i) {
            const glm::vec3 centre(many.x[i], many.y[i], many.z[i]);
            Map::Spheres one;
            Map::Sight sight;
            one.add(centre, many.radius[i]);
            map.look(one, &sight);
            EXPECT_EQ(sights[i], sight);
            ++found[int(sight)];
            // Only what is behind the wall, and nowhere beside it.
            if (sight == Map::Sight::hidden) {
                EXPECT_GT(centre.z - many.radius[i], 4);
                EXPECT_LT(centre.x, 0.1f / 4 * centre.z);
            }
        }
    }
    for (const size_t count : found) EXPECT_GT(count, 50u);
}

// Frames that look, of so many, of which those that `pays` names pay.
std::string frames_that_look(int count, const std::function<bool(int)>& pays) {
    scene::OcclusionChoice choice;
    std::string looks;
    for (int frame = 0; frame < count; ++frame) {
        looks += choice.is_due() ? 'x' : '.';
        if (looks.back() == 'x') choice.note(pays(frame));
    }
    return looks;
}

TEST(OcclusionChoice, LeavesFramesAloneWhereItDoesNotPay) {
    EXPECT_EQ(frames_that_look(20, [](int) { return true; }), std::string(20, 'x'));
    EXPECT_EQ(frames_that_look(20, [](int) { return false; }), "xx.x..x....x....x...");
    // One loss is no reason; after a gain all is forgotten.
    EXPECT_EQ(frames_that_look(12, [](int frame) { return frame % 2 == 0; }), std::string(12, 'x'));
    EXPECT_EQ(frames_that_look(12, [](int frame) { return frame > 3; }), "xx.x..xxxxxx");
}

TEST(OcclusionChoice, CountsWhatIsDrawnAgain) {
    EXPECT_TRUE((scene::OcclusionGain{1000, 0.5, 100000, 0}).paid());
    EXPECT_FALSE((scene::OcclusionGain{1000, 0.5, 100000, 90000}).paid());
    EXPECT_FALSE((scene::OcclusionGain{1000, 0.05, 100000, 0}).paid()) << "to prove it costs more";
    EXPECT_FALSE((scene::OcclusionGain{200000, 0.5, 100000, 0}).paid()) << "to look costs more";
    EXPECT_FALSE((scene::OcclusionGain{0, 0, 0, 0}).paid());
    EXPECT_TRUE((scene::OcclusionGain{55, 1, 1000, 0}).paid()) << "all is hidden";
}

TEST(Occlusion, CountsTheSameWithAnyNumberOfThreads) {
    const mesh::Mesh mesh = onion({with_holes(icosphere(6), 7), scaled(icosphere(5), 0.9)});
    const splat::Model model = build_model(mesh);
    for (const geom::View& view : views_of(model, mesh)) {
        core::set_thread_count(1);
        scene::ModelPainter painter(model);
        const Drawn one = draw(painter, view, {}, scene::Occlusion::on);
        core::set_thread_count(16);
        const Drawn many = draw(painter, view, {}, scene::Occlusion::on);
        expect_same(one, many);
    }
    core::set_thread_count(0);
}
