#include "scene/request_order.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace scene {

namespace {

// A splat about the eye has no projected size: it counts as one that is larger than any picture.
constexpr double kMostPx = 1e6;
// Steps of the orders that have some, as factors of priorities.  Neighbours are joined into one request where
// theirs are within a factor of about 3 (fetch/link_estimate.h), which those of two steps never are.
constexpr double kStep = 8;
constexpr double kMostSteps = 40;  // of a float; what is beyond comes with the last

double stepped(double step) {
    return std::pow(kStep, -std::clamp(step, 0.0, kMostSteps));
}

double bounded_px(float px) {
    return px >= 0 && px < float(kMostPx) ? double(px) : kMostPx;
}

class Priority {
  public:
    Priority(std::span<const Lack> lacks, const OrderOptions& options, int picture_height)
        : options_(options), height_(std::max(1, picture_height)) {
        for (const Lack& lack : lacks) first_sweep_ = std::max(first_sweep_, sweep_of(lack));
    }

    double of(const Lack& lack) const {
        if (options_.order == Order::gain) return lack.pixels * bounded_px(lack.node.error_px);
        const bool is_magnified = options_.magnifier && options_.magnifier->holds(glm::dvec2(lack.at_px));
        return plain(lack) * (is_magnified ? options_.magnifier->boost : 1);
    }

  private:
    // 1 at the top of the picture, 0 at the bottom.
    double height_of(const Lack& lack) const {
        const double y = double(lack.at_px.y) / height_;
        return y > 0 ? 1 - std::min(y, 1.0) : 1;  // also what has no place
    }
    double sweep_of(const Lack& lack) const {
        return std::ceil(std::log(std::max(1e-6, bounded_px(lack.node.diameter_px))) /
                         std::log(options_.sweep_base));
    }
    double plain(const Lack& lack) const {
        switch (options_.order) {
            case Order::level:
                return stepped(double(lack.node.level));
            case Order::radius:
                return double(lack.node.radius);
            case Order::screen:
                return bounded_px(lack.node.diameter_px);
            case Order::y:
                return height_of(lack) + 1e-6;
            case Order::sweep:
                return stepped(first_sweep_ - sweep_of(lack)) * (1 + height_of(lack));
            case Order::gain:
                break;
        }
        return 0;
    }

    const OrderOptions& options_;
    double height_;
    double first_sweep_ = -1e9;
};

enum class Merge { sum, largest };

template <class Value>
std::vector<BlockRequest> merged(std::span<const Lack> lacks, Merge merge, const Value& value) {
    std::map<std::pair<size_t, uint64_t>, double> blocks;
    for (const Lack& lack : lacks) {
        const double priority = value(lack);
        if (!(priority > 0)) continue;
        double& of_block = blocks[{lack.model, lack.node.block}];
        of_block = merge == Merge::sum ? of_block + priority : std::max(of_block, priority);
    }
    std::vector<BlockRequest> requests;
    for (const auto& [block, priority] : blocks)
        requests.push_back({block.first, block.second, float(std::clamp(priority, 1e-37, 1e37))});
    std::stable_sort(requests.begin(), requests.end(),
                     [](const BlockRequest& a, const BlockRequest& b) { return a.priority > b.priority; });
    return requests;
}

}  // namespace

std::vector<BlockRequest> requests_for(std::span<const Lack> lacks, const OrderOptions& options,
                                       int picture_height) {
    const Priority priority(lacks, options, picture_height);
    return merged(lacks, options.order == Order::gain ? Merge::sum : Merge::largest,
                  [&](const Lack& lack) { return priority.of(lack); });
}

std::vector<BlockRequest> requests_for_hidden(std::span<const Lack> lacks) {
    return merged(lacks, Merge::sum, [](const Lack& lack) {
        return lack.pixels > 0 ? 0 : bounded_px(lack.node.error_px) * bounded_px(lack.node.diameter_px);
    });
}

}  // namespace scene
