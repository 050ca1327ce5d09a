// Where the eye will be: requests are for the time when their answers are seen, not for now.
//
// The paper asks for where the eye is.  Asking ahead is worth more than a server several times as fast: at 4
// updates a second 27.1 dB and 3.7 % empty pixels become 31.2 dB and 0.6 % (scripts/bench, point-views).
#pragma once

#include <deque>
#include <span>

#include "geom/camera.h"
#include "ppve/depth_image.h"

namespace ppve {

// The eye's way so far.  Times are the caller's clock, seconds, and grow.
class EyeTrack {
  public:
    void add(double time_s, const geom::Camera& camera);

    // Straight on from the last tenth of a second: moved on, turned on.  Not farther than half a second's
    // turn of 60 degrees, so that a noisy tracker throws it nowhere.  Not after an eye that has stopped.
    // There is a pose at least.
    geom::Camera at(double time_s) const;

    const geom::Camera& last() const { return poses_.back(); }
    double turning_rad_per_s() const;
    // For how long the last pose has been the same, up to the last time.
    double still_s() const;
    bool is_empty() const { return poses_.empty(); }

  private:
    const geom::Camera& before() const;  // a tenth of a second before the last, or the oldest

    std::deque<geom::Camera> poses_;  // their times are the caller's
    double still_since_s_ = 0;
};

// Radians beside a picture that are asked for, too, once it is complete: an eye that sets off is ahead of the
// first answers, whose requests could not foretell that.
constexpr double kSurroundings = 0.1;

// How long a request takes, from asking to seeing.
class Latency {
  public:
    void add(double seconds);
    double seconds() const { return seconds_; }

  private:
    double seconds_ = 0.25;
    bool is_known_ = false;
};

// The picture of one or two eyes as tangents from a point between them.
struct FieldOfView {
    double left, right, top, bottom;  // tangents, positive
    double half_separation = 0;       // of the eyes, world units
    double focal_px = 0;              // of their pictures
};
FieldOfView field_of(const geom::Camera& camera, std::span<const geom::View> eyes);

// One frustum that holds the pictures of all eyes of a camera, with `margin_rad` more on each side, on about
// width x height pixels: as dense as without the margin, so there are more pixels with it.  `most_pixels`
// bounds them.
Frustum frustum_for(const geom::Camera& camera, const FieldOfView& field, int width, int height,
                    double margin_rad, uint64_t most_pixels);

}  // namespace ppve
