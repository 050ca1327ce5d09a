#include "ppve/client/eye_track.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace ppve {

namespace {

constexpr double kWindow = 0.1;       // seconds that a speed is measured over
constexpr double kMostTurn = 0.5236;  // radians that are extrapolated
constexpr double kMostTangent = 5.7;  // 80 degrees to a side

bool is_same(const geom::Camera& a, const geom::Camera& b) {
    return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fovy_deg == b.fovy_deg;
}

glm::dmat3 axes_of(const geom::Camera& camera) {
    const geom::View view = geom::make_view(camera, 1, 1);
    return {view.right, view.down, view.forward};
}

}  // namespace

void EyeTrack::add(double time_s, const geom::Camera& camera) {
    if (poses_.empty() || !is_same(poses_.back(), camera)) still_since_s_ = time_s;
    poses_.push_back(camera);
    poses_.back().time_s = time_s;
    while (poses_.size() > 2 && poses_[1].time_s <= time_s - kWindow) poses_.pop_front();
}

const geom::Camera& EyeTrack::before() const {
    return poses_.front();
}

double EyeTrack::still_s() const {
    return poses_.back().time_s - still_since_s_;
}

double EyeTrack::turning_rad_per_s() const {
    const double dt = last().time_s - before().time_s;
    if (!(dt > 0)) return 0;
    const glm::dquat turn = glm::quat_cast(axes_of(last()) * glm::transpose(axes_of(before())));
    return 2 * std::acos(std::min(1.0, std::fabs(turn.w))) / dt;
}

geom::Camera EyeTrack::at(double time_s) const {
    geom::Camera camera = last();
    const double dt = last().time_s - before().time_s, ahead = time_s - last().time_s;
    if (!(dt > 0 && ahead > 0) || (poses_.size() > 1 && is_same(poses_[poses_.size() - 2], last())))
        return camera;
    const glm::dvec3 moved = last().eye - before().eye;
    const glm::dmat3 then = axes_of(before()), now = axes_of(last());
    glm::dquat turn = glm::quat_cast(now * glm::transpose(then));
    if (turn.w < 0) turn = -turn;
    const double angle = 2 * std::acos(std::min(1.0, turn.w));
    double steps = ahead / dt;
    if (angle * steps > kMostTurn) steps = kMostTurn / angle;
    const glm::dvec3 axis(turn.x, turn.y, turn.z);
    const double length = glm::length(axis);
    const glm::dquat further =
        length > 0 ? glm::angleAxis(angle * steps, axis / length) : glm::dquat(1, 0, 0, 0);
    camera.eye = last().eye + steps * moved;
    camera.target = camera.eye + further * (last().target - last().eye);
    camera.up = further * last().up;
    return camera;
}

void Latency::add(double seconds) {
    constexpr double kShare = 0.25;  // of the newest
    seconds_ = is_known_ ? seconds_ + kShare * (seconds - seconds_) : seconds;
    is_known_ = true;
}

FieldOfView field_of(const geom::Camera& camera, std::span<const geom::View> eyes) {
    FieldOfView field{0, 0, 0, 0, 0, 0};
    for (const geom::View& eye : eyes) {
        const glm::dvec2 principal = eye.principal_in_raster();
        field.left = std::max(field.left, principal.x / eye.focal_px);
        field.right = std::max(field.right, (eye.width - principal.x) / eye.focal_px);
        field.top = std::max(field.top, principal.y / eye.focal_px);
        field.bottom = std::max(field.bottom, (eye.height - principal.y) / eye.focal_px);
        field.half_separation = std::max(field.half_separation, glm::length(eye.eye - camera.eye));
        field.focal_px = std::max(field.focal_px, eye.focal_px);
    }
    return field;
}

Frustum frustum_for(const geom::Camera& camera, const FieldOfView& field, int width, int height,
                    double margin_rad, uint64_t most_pixels) {
    const auto widened = [&](double tangent) {
        return std::clamp(std::tan(std::min(std::atan(tangent) + margin_rad, std::atan(kMostTangent))),
                          tangent, std::max(tangent, kMostTangent));
    };
    const double across = field.left + field.right, down = field.top + field.bottom;
    double focal_px = std::min(width / across, height / down);
    const double left = widened(field.left), right = widened(field.right);
    const double top = widened(field.top), bottom = widened(field.bottom);
    const double pixels = (left + right) * (top + bottom) * focal_px * focal_px;
    if (pixels > double(most_pixels)) focal_px *= std::sqrt(double(most_pixels) / pixels) * 0.999;
    focal_px = std::min(focal_px, (kMostSide - 1) / std::max(left + right, top + bottom));

    Frustum frustum;
    geom::View& view = frustum.view;
    view = geom::make_view(camera, std::max(1, int((left + right) * focal_px)),
                           std::max(1, int((top + bottom) * focal_px)));
    view.focal_px = focal_px;
    view.shift_px = {0.5 * (left - right) * focal_px, 0.5 * (top - bottom) * focal_px};
    // From behind the eyes, where one frustum as wide as theirs holds both.
    if (field.half_separation > 0) view.eye -= view.forward * (field.half_separation / std::max(left, right));
    return frustum;
}

}  // namespace ppve
