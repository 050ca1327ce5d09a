// Frame reports: that they say what frame-report(5) says, and nothing else.
#include "scene/frame_report.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <map>
#include <regex>

#include "test_meshes.h"

using namespace splat_test;

namespace {

scene::FrameReport full_report(splat::CutBy by) {
    scene::FrameReport report;
    report.cut.by = by;
    report.eye = "left";
    report.reference.emplace();
    report.budget = {.budget_ms = 33};
    report.refinement = {1, 50};
    report.stream.emplace();
    return report;
}

// How often each key is documented: the first column of the page's tables, and the words in italics that
// are objects of keys or keys of nodes_culled.
std::map<std::string, int> documented_keys() {
    std::ifstream page(std::string(QS_SOURCE) + "/man/frame-report.5");
    std::map<std::string, int> keys;
    const std::regex row(R"(^([a-z0-9_]+)\|.*T\{$)");
    std::smatch match;
    for (std::string line; std::getline(page, line);) {
        if (std::regex_match(line, match, row)) ++keys[match[1]];
        if (std::regex_match(line, match, std::regex(R"(^\.IR? (frustum|backface|occlusion|stream)( ,)?$)")))
            ++keys[match[1]];
    }
    return keys;
}

void add_keys(const core::Json& json, std::map<std::string, int>& keys) {
    for (const auto& [key, value] : json.items()) {
        keys[key] = 1;
        if (value.is_object()) add_keys(value, keys);
    }
}

}  // namespace

TEST(FrameReport, HasTheKeysOfItsManPageEachOnce) {
    std::map<std::string, int> keys;
    add_keys(scene::to_json(full_report(splat::CutBy::error)), keys);
    add_keys(scene::to_json(full_report(splat::CutBy::diameter)), keys);
    add_keys(scene::to_json_of_failure(3, "path.jsonl: line 4: is wrong"), keys);
    EXPECT_EQ(documented_keys(), keys);
}

TEST(FrameReport, HasMeasuresOnlyWithAReference) {
    scene::FrameReport report = full_report(splat::CutBy::error);
    EXPECT_TRUE(scene::to_json(report).contains("psnr_db"));
    EXPECT_TRUE(scene::to_json(report)["ms"].contains("reference"));
    report.reference.reset();
    EXPECT_FALSE(scene::to_json(report).contains("psnr_db"));
    EXPECT_FALSE(scene::to_json(report)["ms"].contains("reference"));
}

TEST(FrameReport, WritesNullForWhatIsInfinite) {
    scene::FrameReport report;
    report.draw.counts.error_bound_px = std::numeric_limits<double>::infinity();
    EXPECT_NE(scene::to_json(report).dump().find("\"error_bound_px\":null"), std::string::npos);
}

TEST(FrameReport, SumsItsTimes) {
    scene::FrameReport report = full_report(splat::CutBy::error);
    report.draw.traverse_ms = 1, report.draw.draw_ms = 2, report.write_ms = 4, report.reference_ms = 8;
    report.budget->predict_ms = 16;
    EXPECT_EQ(scene::to_json(report)["ms"]["total"], 23.0);
}

TEST(FrameReport, SaysByHowMuchABudgetWasExceeded) {
    scene::FrameReport report;
    EXPECT_FALSE(scene::to_json(report).contains("overshoot"));
    report.budget = {.budget_ms = 20, .predicted_ms = 19, .predict_ms = 2};
    report.draw.traverse_ms = 10, report.draw.draw_ms = 13, report.write_ms = 1000;
    const core::Json late = scene::to_json(report);
    EXPECT_EQ(late["budget_ms"], 20.0);
    EXPECT_EQ(late["predicted_ms"], 19.0);
    EXPECT_DOUBLE_EQ(late["overshoot"], 0.25) << "the writer's time does not count";
    report.draw.draw_ms = 7;
    EXPECT_EQ(scene::to_json(report)["overshoot"], 0.0);
}

TEST(FrameReport, NamesTheThresholdByItsMeaning) {
    scene::FrameReport report = full_report(splat::CutBy::diameter);
    report.cut.threshold_px = 3;
    const core::Json json = scene::to_json(report);
    EXPECT_EQ(json["threshold_diameter_px"], 3.0);
    EXPECT_FALSE(json.contains("threshold_px"));
}

TEST(FrameReport, SaysWhereNothingFinerWasThere) {
    scene::FrameReport report;
    report.cut.threshold_px = 0.5;
    for (const auto& [bound_px, misses] :
         {std::pair(0.4, false), {0.5, false}, {0.51, true}, {INFINITY, true}}) {
        report.draw.counts.error_bound_px = bound_px;
        EXPECT_EQ(report.misses_threshold(), misses) << bound_px;
    }
    report.cut.threshold_px = 0;
    EXPECT_FALSE(report.misses_threshold()) << "all detail was asked for, and drawn";
    report.cut.threshold_px = 0.5, report.cut.by = splat::CutBy::diameter;
    EXPECT_FALSE(report.misses_threshold());
}

TEST(FrameReport, RoundsTimesToMicroseconds) {
    scene::FrameReport report = full_report(splat::CutBy::error);
    report.draw.traverse_ms = 1.2344567, report.draw.draw_ms = 2.0004, report.write_ms = 0.0004;
    EXPECT_EQ(scene::to_json(report)["ms"].dump(),
              R"({"predict":0.0,"traverse":1.234,"draw":2.0,"write":0.0,"total":3.235,"reference":0.0})");
}
