#include "splat/cut_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace splat {

CutProfile::CutProfile(const ProfileOptions& options, uint64_t picture_pixels)
    : finest_px_(options.finest_px > 0 ? options.finest_px : 0),
      most_splats_(options.most_splats),
      most_pixels_(double(picture_pixels)) {}

double CutProfile::threshold_px(int step) const {
    if (step == 0) return finest_px_;
    return std::max(finest_px_, kFinestPx) * std::exp2(double(step) / kStepsPerOctave);
}

int CutProfile::step_of(double threshold_px) const {
    if (threshold_px <= finest_px_) return 0;
    const double step =
        std::ceil(kStepsPerOctave * std::log2(threshold_px / std::max(finest_px_, kFinestPx)));
    return step < kSteps ? std::max(int(step), 1) : kSteps;
}

void CutProfile::add(const CutProfile& other) {
    first_step_ = std::max(first_step_, other.first_step_);
    for (size_t step = 0; step < sizes_.size(); ++step) sizes_[step].add(other.sizes_[step]);
}

void CutProfile::add_splat(int from, int to, double diameter_px, double weight) {
    if (from >= to) return;
    const double pixels = std::min(std::numbers::pi / 4 * diameter_px * diameter_px, most_pixels_);
    const CutSize size{0, 0, weight, weight * pixels};
    sizes_[size_t(from)].add(size);
    sizes_[size_t(to)].add(size, -1);
}

void CutProfile::add_nodes(int to, double count, bool is_cold) {
    const CutSize size{count, is_cold ? count : 0, 0, 0};
    sizes_[0].add(size);
    sizes_[size_t(to)].add(size, -1);
}

void CutProfile::limit(std::span<const int> waiting_steps, double weight) {
    std::array<double, kSteps + 1> change{};
    for (const int step : waiting_steps) change[0] += weight, change[size_t(step)] -= weight;
    double splats = 0;
    int first = 0;
    for (int step = 0; step < kSteps; ++step) {
        splats += sizes_[size_t(step)].splats + change[size_t(step)];
        if (splats > most_splats_) first = step + 1;
    }
    // The coarsest cut is known whatever it holds.
    first_step_ = std::min(std::max(first_step_, first), kSteps - 1);
}

void CutProfile::finish() {
    for (size_t step = 1; step < sizes_.size(); ++step) sizes_[step].add(sizes_[step - 1]);
}

}  // namespace splat
