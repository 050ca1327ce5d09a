#include "scene/stream_report.h"

#include <cmath>

#include "core/error.h"

namespace scene {

namespace {

core::Json seconds(const std::optional<double>& time_s) {
    return time_s ? core::Json(std::round(*time_s * 1e6) / 1e6) : core::Json();
}

}  // namespace

core::Json to_json(const StreamReport& report) {
    core::Json json;
    json["elapsed_s"] = seconds(report.elapsed_s);
    json["bytes_fetched"] = report.network.bytes;
    json["requests"] = report.network.requests;
    json["blocks_missing"] = report.blocks_missing;
    json["visible_blocks_missing"] = report.visible_blocks_missing;
    json["waiting_error_px"] = report.waiting_error_px;
    json["hit_rate"] = report.hit_rate;
    json["visible_hit_rate"] = report.visible_hit_rate;
    json["cache_hit_rate"] = report.cache_hit_rate;
    json["wasted_bytes"] = report.wasted_bytes;
    json["is_budget_used"] = report.is_budget_used;
    json["first_picture_s"] = seconds(report.first_picture_s);
    json["full_coverage_s"] = seconds(report.full_coverage_s);
    for (size_t i = 0; i < kErrorSteps_px.size(); ++i)
        json[core::text("error_below_%gpx_s", kErrorSteps_px[i])] = seconds(report.error_below_s[i]);
    return json;
}

}  // namespace scene
