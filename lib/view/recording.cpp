#include "view/recording.h"

namespace view {

void Recording::add(const geom::Camera& camera) {
    if (path_.size() == kMostFrames) return;
    path_.push_back(camera);
    path_.back().time_s = double(path_.size() - 1) / kFps;
}

void Recording::note(const geom::Camera& camera, double time_s) {
    while (path_.size() < kMostFrames && double(path_.size()) / kFps <= time_s - begin_s_) add(camera);
}

void Recording::end(const geom::Camera& camera, double time_s) {
    note(camera, time_s);
    geom::Camera last = camera;
    if (!path_.empty()) last.time_s = path_.back().time_s;
    if (path_.empty() || geom::format_camera(path_.back()) != geom::format_camera(last)) add(camera);
}

}  // namespace view
