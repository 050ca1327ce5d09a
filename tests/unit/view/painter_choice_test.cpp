#include "view/painter_choice.h"

#include <gtest/gtest.h>

#include <map>

#include "render/splatter.h"
#include "splat/model.h"

namespace {

scene::Backend backend(const std::string& name) {
    return {std::make_unique<render::Splatter>(), name, "of the test", ""};
}

// Names of back ends, and what a frame takes with each by turns.
class PainterChoice : public testing::Test {
  protected:
    view::ChosenPainter choose(const std::vector<std::pair<std::string, double>>& times_ms) {
        std::vector<scene::Backend> backends;
        for (const auto& [name, ms] : times_ms) backends.push_back(backend(name));
        return view::fastest_painter({{&model_}}, std::move(backends), [&](scene::ModelPainter& painter) {
            const auto& [name, ms] = times_ms[measured_.size()];
            measured_[&painter] = name;
            return ms;
        });
    }

    splat::Model model_{std::string(QS_TEST_DATA) + "/bumpy.qs"};
    std::map<scene::ModelPainter*, std::string> measured_;
};

TEST_F(PainterChoice, TakesTheOneThatIsMeasuredToBeFaster) {
    const view::ChosenPainter chosen = choose({{"egl", 3}, {"cpu", 5.5}});
    EXPECT_EQ(measured_[chosen.painter.get()], "egl");
    EXPECT_EQ(chosen.description, "egl: of the test (a frame: egl 3.0 ms, cpu 5.5 ms)");
}

TEST_F(PainterChoice, TakesTheProcessorWhereThatIsFaster) {
    const view::ChosenPainter chosen = choose({{"egl", 8}, {"cpu", 5}});
    EXPECT_EQ(measured_[chosen.painter.get()], "cpu");
    EXPECT_EQ(chosen.description, "cpu: of the test (a frame: egl 8.0 ms, cpu 5.0 ms)");
}

TEST_F(PainterChoice, OfEqualsIsTheGraphicsProcessorWhichLeavesTheOtherFree) {
    EXPECT_TRUE(choose({{"egl", 5}, {"cpu", 5}}).description.starts_with("egl"));
}

TEST_F(PainterChoice, OfASingleOneMeasuresNothing) {
    const view::ChosenPainter chosen = choose({{"cpu", 5}});
    EXPECT_TRUE(measured_.empty());
    EXPECT_EQ(chosen.description, "cpu: of the test");
}

TEST(BackendsToChooseFrom, AreTheOneThatWasAskedForByName) {
    const std::vector<scene::Backend> backends = view::backends_to_choose_from(scene::BackendKind::cpu);
    ASSERT_EQ(backends.size(), 1u);
    EXPECT_EQ(backends[0].name, "cpu");
}

// With and without a graphics processor.
TEST(BackendsToChooseFrom, AlwaysHaveTheProcessorWhereNoneWasAskedFor) {
    const std::vector<scene::Backend> backends = view::backends_to_choose_from(scene::BackendKind::automatic);
    EXPECT_EQ(backends.back().name, "cpu");
    EXPECT_EQ(backends.size() == 1, backends.front().name == "cpu");
}

}  // namespace
