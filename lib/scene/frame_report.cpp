#include "scene/frame_report.h"

#include <algorithm>
#include <cmath>

#include "scene/stream_report.h"

namespace scene {

namespace {

// To whole microseconds: a clock's further digits mean nothing.
double rounded(double ms) {
    return std::round(ms * 1000) / 1000;
}

}  // namespace

void add_reference(core::Json& json, const ReferenceMeasures& measures) {
    const render::ImageDifference& d = measures.difference;
    json["psnr_db"] = d.psnr_db;
    json["psnr_inside_db"] = d.psnr_inside_db;
    json["ssim"] = d.ssim;
    json["coverage_iou"] = d.coverage_iou;
    json["silhouette_growth"] = d.silhouette_growth;
    json["holes"] = d.holes;
    json["holes_inside"] = d.holes_inside;
    json["show_through"] = d.show_through.value_or(0);
    json["depth_rmse_px"] = d.depth_rmse_px ? core::Json(*d.depth_rmse_px) : core::Json();
    json["measured_error_px"] = measures.measured_error_px;
}

core::Json to_json(const FrameReport& report) {
    const splat::CutCounts& counts = report.draw.counts;
    core::Json json;
    json["frame"] = report.frame;
    if (!report.eye.empty()) json["eye"] = report.eye;
    json["t"] = report.time_s;
    json["backend"] = report.backend;
    core::Json& ms = json["ms"];
    if (report.budget) ms["predict"] = rounded(report.budget->predict_ms);
    ms["traverse"] = rounded(report.draw.traverse_ms);
    ms["draw"] = rounded(report.draw.draw_ms);
    ms["write"] = rounded(report.write_ms);
    ms["total"] = rounded(report.total_ms());
    if (report.reference) ms["reference"] = rounded(report.reference_ms);
    if (report.refinement) {
        json["refinement"] = report.refinement->number;
        json["elapsed_ms"] = rounded(report.refinement->elapsed_ms);
    }
    if (report.budget) {
        json["budget_ms"] = report.budget->budget_ms;
        json["predicted_ms"] = rounded(report.budget->predicted_ms);
        json["overshoot"] = std::max(0.0, report.drawing_ms() / report.budget->budget_ms - 1);
    }
    json["nodes_visited"] = counts.nodes_visited;
    json["nodes_culled"] = {{"frustum", counts.frustum_culled},
                            {"backface", counts.backface_culled},
                            {"occlusion", counts.occlusion_culled}};
    json["splats"] = counts.splats;
    json["triangles"] = counts.triangles;
    const bool by_error = report.cut.by == splat::CutBy::error;
    json[by_error ? "threshold_px" : "threshold_diameter_px"] = report.cut.threshold_px;
    json["error_bound_px"] = counts.error_bound_px;
    json["blocks_touched"] = counts.blocks_touched;
    json["bytes_touched"] = report.draw.bytes_touched;
    json["groups_missing"] = counts.groups_missing;
    json["model_blocks"] = report.draw.model_blocks;
    json["model_blocks_present"] = report.draw.model_blocks_present;
    if (report.stream) json["stream"] = to_json(*report.stream);
    if (report.reference) add_reference(json, *report.reference);
    return json;
}

core::Json to_json_of_failure(int frame, const std::string& error) {
    return {{"frame", frame}, {"error", error}};
}

}  // namespace scene
