// Profiles of a view: the cuts they speak of, counted.
#include <gtest/gtest.h>

#include "core/error.h"
#include "splat/cut.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;
using splat::CutBy;
using splat::CutProfile;
using splat::ProfileOptions;

namespace {

constexpr size_t kAll = size_t(1) << 40;  // no level has more nodes

splat::CutCounts counts_of(const splat::Model& model, const geom::View& view,
                           const splat::CutOptions& options) {
    splat::Cut cut(model);
    const size_t tasks = cut.begin(view, options);
    for (size_t task = 0; task < tasks; ++task) cut.run(task, [](const geom::SplatBatch&) {});
    return cut.counts();
}

CutProfile profile_of(const splat::Model& model, const geom::View& view, const ProfileOptions& limits,
                      CutBy by = CutBy::error) {
    splat::CutOptions options;
    options.by = by;
    return splat::Cut(model).profile(view, options, limits);
}

std::vector<geom::View> views_of(const splat::Model& model, const mesh::Mesh& mesh) {
    std::vector<geom::View> views = random_views(model, mesh, 5);
    for (const geom::View& view : close_views(model, mesh, 3)) views.push_back(view);
    views.push_back(fitted_view(model));
    return views;
}

// A walk over all nodes; a threshold of exactly what a node needs is a matter of rounding.
void expect_exact(const splat::Model& model, const geom::View& view, double finest_px, CutBy by) {
    const CutProfile profile = profile_of(model, view, {finest_px, 1e18, kAll}, by);
    for (int step = 0; step < CutProfile::kSteps; step += step == 0 ? 1 : 9) {
        splat::CutOptions options;
        options.by = by;
        options.threshold_px = profile.threshold_px(step);
        const splat::CutCounts counts = counts_of(model, view, options);
        EXPECT_NEAR(profile.at(step).splats, double(counts.splats), 2 + 1e-3 * double(counts.splats)) << step;
        EXPECT_NEAR(profile.at(step).nodes, double(counts.nodes_visited),
                    12 + 1e-3 * double(counts.nodes_visited))
            << step;
    }
}

}  // namespace

TEST(CutProfile, CountsTheCutsOfAllThresholdsWhereNoNodeIsLeftOut) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    for (const geom::View& view : views_of(model, mesh))
        for (const CutBy by : {CutBy::error, CutBy::diameter})
            for (const double finest_px : {0.0, 0.3}) expect_exact(model, view, finest_px, by);
}

TEST(CutProfile, CountsTheCutsOfAPrefix) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    Bytes bytes = build_bytes(mesh);
    bytes.resize(bytes.size() / 3);
    const splat::Model model = open_model(bytes);
    for (const geom::View& view : views_of(model, mesh)) expect_exact(model, view, 0, CutBy::error);
}

TEST(CutProfile, EstimatesLargeCutsFromASample) {
    const splat::Model model = build_model(bumpy_torus(300, 700));
    const geom::View view = fitted_view(model, 1280, 720);
    const CutProfile all = profile_of(model, view, {0.2, 1e18, kAll});
    const CutProfile sample = profile_of(model, view, {0.2, 1e18, 512});
    for (int step = 0; all.at(step).splats > 20e3; ++step) {
        EXPECT_NEAR(sample.at(step).splats, all.at(step).splats, 0.1 * all.at(step).splats) << step;
        EXPECT_NEAR(sample.at(step).nodes, all.at(step).nodes, 0.1 * all.at(step).nodes) << step;
        EXPECT_NEAR(sample.at(step).pixels, all.at(step).pixels, 0.15 * all.at(step).pixels) << step;
    }
    EXPECT_GT(all.at(0).splats, 20e3);
}

TEST(CutProfile, LeavesOutWhatIsLargerThanAsked) {
    const splat::Model model = build_model(bumpy_torus(300, 700));
    const geom::View view = fitted_view(model, 1280, 720);
    const CutProfile all = profile_of(model, view, {0, 1e18, kAll});
    const CutProfile some = profile_of(model, view, {0, 1000, kAll});
    EXPECT_EQ(all.first_step(), 0);
    EXPECT_GT(some.first_step(), 0);
    EXPECT_GT(all.at(some.first_step() - 1).splats, 1000);
    for (int step = some.first_step(); step < CutProfile::kSteps; ++step)
        EXPECT_NEAR(some.at(step).splats, all.at(step).splats, 1e-6) << step;
}

TEST(CutProfile, KnowsTheCoarsestCutWhateverItHolds) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const CutProfile profile = profile_of(model, fitted_view(model), {0, 0, kAll});
    ASSERT_LT(profile.first_step(), CutProfile::kSteps);
    EXPECT_GT(profile.at(profile.first_step()).splats, 0);
}

TEST(CutProfile, TellsNodesThatNoFrameHasUsed) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const geom::View view = fitted_view(model);
    splat::Cut cut(model);
    const ProfileOptions limits{0, 1e18, kAll};
    for (int i = 0; i < 2; ++i) {
        const CutProfile before = cut.profile(view, {}, limits);
        EXPECT_EQ(before.at(0).cold_nodes, before.at(0).nodes) << "a profile is no frame";
    }
    splat::CutOptions all_detail;
    all_detail.threshold_px = 0;
    for (int frame = 0; frame < 600; ++frame) {  // the stamps of frames begin anew after 255
        const size_t tasks = cut.begin(view, all_detail);
        for (size_t task = 0; task < tasks; ++task) cut.run(task, [](const geom::SplatBatch&) {});
        if (frame % 100 == 0 || frame == 255 || frame == 256) {
            EXPECT_EQ(cut.profile(view, {}, limits).at(0).cold_nodes, 0) << frame;
            EXPECT_EQ(cut.counts().blocks_touched, counts_of(model, view, all_detail).blocks_touched)
                << frame;
        }
    }
}

TEST(CutProfile, HasThresholdsThatGrowAndStepsThatFindThem) {
    for (const double finest_px : {0.0, 1e-30, 1.0 / 128, 1.0, 1e6}) {
        const CutProfile profile({finest_px, 1e18, 512}, 1);
        EXPECT_EQ(profile.threshold_px(0), finest_px);
        for (int step = 1; step < CutProfile::kSteps; ++step) {
            const double threshold_px = profile.threshold_px(step);
            EXPECT_GT(threshold_px, profile.threshold_px(step - 1));
            EXPECT_GE(profile.step_of(1.001 * threshold_px), step + 1);
            EXPECT_LE(profile.step_of(0.999 * threshold_px), step);
        }
        EXPECT_EQ(profile.step_of(finest_px), 0);
        EXPECT_EQ(profile.step_of(std::numeric_limits<double>::infinity()), CutProfile::kSteps);
        EXPECT_EQ(profile.step_of(std::nan("")), CutProfile::kSteps);
    }
}

TEST(CutProfile, OfTwoModelsIsTheSum) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    const geom::View view = fitted_view(model);
    CutProfile sum = profile_of(model, view, {1, 1e18, 512});
    const CutProfile one = sum;
    sum.add(one);
    EXPECT_EQ(sum.at(3).splats, 2 * one.at(3).splats);
    EXPECT_EQ(sum.at(3).nodes, 2 * one.at(3).nodes);
}

TEST(CutProfile, RefusesADamagedModel) {
    Bytes bytes = build_bytes(bumpy_torus(60, 160));
    bytes[bytes.size() / 2] ^= std::byte(4);
    const splat::Model model = open_model(bytes);
    EXPECT_THROW(profile_of(model, fitted_view(model), {0, 1e18, kAll}), core::Error);
}
