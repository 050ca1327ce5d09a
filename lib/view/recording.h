// The way of a camera, taken down at even times, for qs-render to draw.
#pragma once

#include <string>
#include <vector>

#include "geom/camera.h"

namespace view {

class Recording {
  public:
    static constexpr double kFps = 30;
    // 55 minutes; what comes after is not taken down.
    static constexpr size_t kMostFrames = 100'000;

    // Frame i is where the camera was at time i / kFps since `begin_s`.
    explicit Recording(double begin_s) : begin_s_(begin_s) {}

    // The camera is here from the last call on.  Frames whose time has come are taken down.
    void note(const geom::Camera& camera, double time_s);
    // And the last one, where the camera is now.
    void end(const geom::Camera& camera, double time_s);

    size_t frames() const { return path_.size(); }
    double length_s() const { return double(path_.size()) / kFps; }
    // As in camera-path(5).
    std::string text() const { return geom::format_path(path_); }

  private:
    void add(const geom::Camera& camera);

    double begin_s_;
    std::vector<geom::Camera> path_;
};

}  // namespace view
