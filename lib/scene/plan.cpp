#include "scene/plan.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/error.h"
#include "splat/level_prefix.h"

namespace scene {

namespace {

// From one level to the next, in models as qs-build makes them: how many nodes, and how much smaller their
// sizes and errors are (scanned surfaces are rough, and the error falls as the size does).
constexpr double kFanOut = 6.6, kShrinking = 2.57;

// Where levels begin, in blocks of the file: known as far as they are there, and beyond that by the fan-out.
class Levels {
  public:
    explicit Levels(const splat::Model& model) : end_(double(model.header().node_blocks())) {
        const splat::Header& header = model.header();
        bool is_known = true;
        begin_ = {0, 0};
        while (begin_.size() <= header.level_count) {
            const auto level = uint32_t(begin_.size() - 1);
            const splat::LevelPrefix prefix =
                is_known ? splat::level_prefix(model, level) : splat::LevelPrefix();
            is_known = prefix.is_known;
            const double last = begin_.back() - begin_[begin_.size() - 2];
            const double next =
                is_known ? double(prefix.blocks) : begin_.back() + kFanOut * std::max(last, 1 / kFanOut);
            begin_.push_back(std::clamp(next, begin_.back(), end_));
        }
    }
    size_t count() const { return begin_.size() - 1; }
    double begin(size_t level) const { return level < begin_.size() ? begin_[level] : end_; }
    double blocks(size_t level) const { return begin(level + 1) - begin(level); }

  private:
    double end_;
    std::vector<double> begin_;  // by level, from 1
};

// Which blocks of one model. Nodes stand in each level in the same order, so that what is below a block is
// the same part of each level.
class Needed {
  public:
    explicit Needed(const splat::Model& model)
        : model_(model), levels_(model), is_needed_(model.header().block_count, false) {}

    // What waits for one block.
    void add(std::span<const Lack> waiting, const splat::CutOptions& cut) {
        const splat::WaitingNode& first = waiting[0].node;
        is_needed_[first.block] = true;
        const size_t children = first.level + 1;
        const double blocks = levels_.blocks(children);
        if (first.block >= model_.header().node_blocks() || blocks <= 0) return;
        const double at = (double(first.block) - levels_.begin(children)) / blocks;
        const double most = double(model_.layout().capacity) / splat::kMaxFanOut;
        double smaller = 1;
        for (size_t level = children + 1; level <= levels_.count(); ++level) {
            smaller *= kShrinking;
            const auto opened = std::count_if(waiting.begin(), waiting.end(), [&](const Lack& lack) {
                return is_opened(lack.node, smaller, cut);
            });
            if (opened == 0) return;
            // So many blocks has what is below the block on this level; each is needed where one of the nodes
            // that it belongs to is opened.
            const double below = levels_.blocks(level) / blocks, owners = std::max(1.0, most / below);
            const double closed = 1 - std::min(1.0, double(opened) / most);
            mark(levels_.begin(level) + at * levels_.blocks(level), below * (1 - std::pow(closed, owners)));
        }
    }

    uint64_t missing() const {
        uint64_t count = 0;
        for (uint64_t b = 0; b < is_needed_.size(); ++b) count += is_needed_[b] && !model_.is_there(b);
        return count;
    }

  private:
    static bool is_opened(const splat::WaitingNode& node, double smaller, const splat::CutOptions& cut) {
        const double least = cut.threshold_px * smaller;
        if (cut.by == splat::CutBy::diameter) return double(node.diameter_px) > least;
        return double(node.error_px) > least || double(node.diameter_px) > splat::kDiameterOfError * least;
    }

    void mark(double at, double count) {
        const double most = levels_.begin(levels_.count() + 1) - 1;
        const auto first = uint64_t(std::clamp(std::floor(at), 0.0, most)),
                   last = uint64_t(std::clamp(std::ceil(at + count) - 1, 0.0, most));
        for (uint64_t b = first; b <= last; ++b) is_needed_[b] = true;
    }

    const splat::Model& model_;
    const Levels levels_;
    std::vector<bool> is_needed_;  // by block
};

}  // namespace

Plan plan_of(std::span<const PlacedModel> models, std::span<const Lack> lacks, const splat::CutOptions& cut) {
    Plan plan;
    for (size_t m = 0; m < models.size(); ++m) {
        const splat::Model& model = *models[m].model;
        plan.file_bytes += model.size_bytes();
        plan.present_bytes += model.blocks_used() * model.mean_block_bytes();
        Needed needed(model);
        std::vector<Lack> waiting;
        std::copy_if(lacks.begin(), lacks.end(), std::back_inserter(waiting),
                     [&](const Lack& lack) { return lack.model == m; });
        std::sort(waiting.begin(), waiting.end(),
                  [](const Lack& a, const Lack& b) { return a.node.block < b.node.block; });
        for (auto begin = waiting.begin(), end = begin; begin != waiting.end(); begin = end) {
            end = std::find_if(begin, waiting.end(),
                               [&](const Lack& lack) { return lack.node.block != begin->node.block; });
            needed.add({begin, end}, cut);
        }
        plan.missing_bytes += needed.missing() * model.mean_block_bytes();
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
