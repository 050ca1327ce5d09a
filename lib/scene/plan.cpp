#include "scene/plan.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace scene {

namespace {

constexpr double kFanOut = 5.5;  // on average, in models as qs-build makes them

// Nodes that will be visited below one that waits: those that are drawn in the end, and the levels between.
double nodes_below(const splat::WaitingNode& node, const splat::CutOptions& cut, double most) {
    const double finest_px = std::max(cut.threshold_px, 1e-3);
    const bool by_error = cut.by == splat::CutBy::error;
    // How many times smaller they will be: scanned surfaces are rough, and the error falls as the size does.
    const double by_size =
        double(node.diameter_px) / (by_error ? splat::kDiameterOfError * finest_px : finest_px);
    const double smaller = std::max(by_size, by_error ? double(node.error_px) / finest_px : 0);
    const double drawn = smaller * smaller < most ? smaller * smaller : most;  // also where it is infinite
    return std::max(kFanOut, drawn) * kFanOut / (kFanOut - 1);
}

}  // namespace

Plan plan_of(std::span<const PlacedModel> models, const DrawReport& drawn, std::span<const Lack> lacks,
             const splat::CutOptions& cut) {
    Plan plan;
    plan.present_bytes = drawn.bytes_touched;
    for (size_t m = 0; m < models.size(); ++m) {
        const splat::Model& model = *models[m].model;
        plan.file_bytes += model.size_bytes();
        // No more than what the node's part of the root's disc can hold.
        const double all = double(model.header().node_count);
        double nodes = 0;
        for (const Lack& lack : lacks)
            if (lack.model == m)
                nodes +=
                    nodes_below(lack.node, cut, all * double(lack.node.radius) * double(lack.node.radius));
        const double left =
            double(model.header().block_count - std::min(model.header().block_count, model.blocks_used()));
        const double blocks = std::min(left, std::ceil(nodes / model.layout().capacity));
        plan.missing_bytes += uint64_t(blocks) * model.header().block_size;
    }
    return plan;
}

std::string to_text(const Plan& plan) {
    const auto kb = [](uint64_t bytes) { return double(bytes) / 1000; };
    if (plan.missing_bytes == 0)
        return core::text("needs %.0f kB of %.0f kB, which are all there\n", kb(plan.present_bytes),
                          kb(plan.file_bytes));
    return core::text("needs about %.0f kB of %.0f kB: %.0f kB are there, about %.0f kB are to be fetched\n",
                      kb(plan.present_bytes + plan.missing_bytes), kb(plan.file_bytes),
                      kb(plan.present_bytes), kb(plan.missing_bytes));
}

core::Json to_json(const Plan& plan) {
    return {{"file_bytes", plan.file_bytes},
            {"present_bytes", plan.present_bytes},
            {"missing_bytes", plan.missing_bytes},
            {"is_estimate", plan.missing_bytes > 0}};
}

}  // namespace scene
