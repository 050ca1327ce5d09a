// What the cuts of a view would hold, threshold by threshold: an estimate from one walk, to choose a
// threshold by.
//
// A node is drawn at a threshold that is at least what it needs (its projected error, or diameter) and below
// what all its ancestors need.  So one walk that opens what the finest cut opens tells the cuts for all
// thresholds. It is a walk over a sample: of each level only so many nodes are opened, evenly spread over the
// level's order, which is that of the tree and so of space; what they hold counts for those that were left
// out, too. The cost does not grow with the model, and 512 nodes a level tell counts to some 3 % (Knuth,
// Estimating the efficiency of backtrack programs, 1975, stratified by level).
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace splat {

struct ProfileOptions {
    double finest_px = 1;       // the finest cut of interest; 0 and less, and NaN: all detail, as for a cut
    double most_splats = 1e18;  // larger cuts are of no interest
    size_t samples = 512;       // nodes opened a level, >= 1
};

// Estimated counts of one cut.
struct CutSize {
    double nodes = 0;       // visited
    double cold_nodes = 0;  // of these, in blocks that no cut has used before
    double splats = 0;
    double pixels = 0;  // areas of the splats' spheres in the picture, each at most the whole picture

    void add(const CutSize& o, double times = 1) {
        nodes += times * o.nodes, cold_nodes += times * o.cold_nodes;
        splats += times * o.splats, pixels += times * o.pixels;
    }
};

class CutProfile {
  public:
    static constexpr int kSteps = 192;  // thresholds: the finest one and 24 octaves
    static constexpr int kStepsPerOctave = 8;
    static constexpr double kFinestPx =
        1.0 / 128;  // steps are even from here on, whatever the finest threshold

    CutProfile(const ProfileOptions& options, uint64_t picture_pixels);

    // Grows with the step; threshold_px(0) is finest_px.
    double threshold_px(int step) const;
    // The first step whose threshold is at least this; kSteps where there is none.
    int step_of(double threshold_px) const;

    // Cuts before this step are larger than most_splats, and not known.
    int first_step() const { return first_step_; }
    const CutSize& at(int step) const { return sizes_[size_t(step)]; }  // step from first_step() on

    // Of several models in one scene: profiles with the same options.
    void add(const CutProfile& other);

    // For the walk.  Steps [from, to) draw the splat; nodes are visited before step `to`.
    void add_splat(int from, int to, double diameter_px, double weight);
    void add_nodes(int to, double count, bool is_cold);
    // Nodes wait that are opened before these steps: drops the steps that hold too much already.
    void limit(std::span<const int> waiting_steps, double weight);
    void finish();  // before at()

  private:
    double finest_px_, most_splats_, most_pixels_;
    int first_step_ = 0;
    std::array<CutSize, kSteps + 1> sizes_{};  // differences from step to step until finish()
};

}  // namespace splat
