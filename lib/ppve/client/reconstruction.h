// A picture of a point model: the paper's two-step splatting, for one eye or two.
//
// Ge et al. 2006, section 5.4.  Step 1: of each patch the level whose pixel range is nearest to the desired
// one, which is the eye's.  Step 2: the splats' size, by equation (1); here at each point, not once for its
// cluster, so that a cluster may reach from the eye to the horizon.  With the revised rule, where a coarse
// patch may hide a finer one of its cluster; and with a budget of points.
//
// The picture depends on the model and the options alone, whatever the number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geom/camera.h"
#include "ppve/client/patch_levels.h"
#include "ppve/client/point_raster.h"
#include "render/frame.h"

namespace ppve {

// A cluster as it is drawn.
struct DrawnCluster {
    uint64_t id = 0;
    std::vector<std::shared_ptr<const PatchLevels>> patches;
};

// The client's points between two updates; not changed any more.
struct PointModel {
    double unit = 1;  // world units in a tree unit
    std::vector<std::shared_ptr<const DrawnCluster>> clusters;
};

// At rest larger splats only blur; in motion along an orbit of the dragon 1.5 leaves a fifth of the empty
// pixels of 1.25 (point_view_bench --what motion).
constexpr double kScaleInMotion = 1.5;

struct ReconstructionOptions {
    double scale = 1;  // the scale factor of equation (1): more covers gaps, and blurs
    // The revised rule: a patch with splats above ratio times those of the best one in its cluster has them
    // reduced to theirs and epsilon of its own.  0: as they are.
    double ratio = 0, epsilon = 0;
    // Of the eye: the desired pixel range is divided by it.  1: at rest.
    double velocity = 1;
    uint64_t most_points = 4'000'000;  // an eye; beyond it the farthest clusters are drawn coarser
    bool closes_gaps = false;          // of one pixel between splats (gaps.h): while the eye moves
    bool is_closed = false;            // the surface is: what faces away is not drawn
    render::Look look{};               // of one sample a pixel

    // Of a picture that all was sampled for that it shows: coarser points that are left at its outlines do
    // not make them fatter.  39 dB become 44 (point_view_bench --what motion, rest_psnr_db).  Where some of
    // it was not, the rule would open gaps.
    static ReconstructionOptions of_complete_picture();
    // Of any other: gaps are closed.  29.6 dB with splats 1.5 times as large instead become 32.3 (likewise).
    static ReconstructionOptions of_moving_eye();
};

struct ReconstructionCounts {
    uint64_t clusters = 0, clusters_seen = 0;  // all; in the frustum
    uint64_t patches_drawn = 0, patches_facing_away = 0;
    uint64_t points_chosen = 0, points_drawn = 0;  // of the patches' levels; those in the picture
    uint64_t coarser_for_budget = 0;               // patches
    double select_ms = 0, draw_ms = 0;             // on the clock
};

class Reconstruction {
  public:
    Reconstruction();
    ~Reconstruction();

    // `frames` are as many as views, and get their sizes.  Throws core::UsageError for more samples than one
    // a pixel. `seen`, where not null, has an entry a cluster of the model, set to 1 where some eye sees it.
    std::vector<ReconstructionCounts> draw(const PointModel& model, std::span<const geom::View> views,
                                           const ReconstructionOptions& options,
                                           std::span<render::Frame> frames,
                                           std::vector<uint8_t>* seen = nullptr);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ppve
