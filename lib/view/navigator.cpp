#include "view/navigator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "view/camera_moves.h"

namespace view {

namespace {

constexpr double kNotch = 0.85;         // of the distance, a notch of the wheel
constexpr double kWideningStep = 1.15;  // of the tangent, a step
constexpr double kDollyPerHeight = 8;   // a drag over the whole height is so many foldings by e / 2
constexpr double kNearest = 1e-6;       // of the bounds' radius: nothing is seen from nearer
constexpr double kRest_s = 0.15;        // after a move, until the camera is taken to be still

}  // namespace

Navigator::Navigator(const geom::Camera& home, const geom::Sphere& bounds)
    : home_(home), camera_(home), nearest_(kNearest * bounds.radius) {}

void Navigator::change(const geom::Camera& camera, double time_s) {
    camera_ = camera;
    moved_s_ = time_s;
}

void Navigator::jump_to(const geom::Camera& camera, double time_s) {
    stop();
    change(camera, time_s);
}

double Navigator::depth_of_target() const {
    return glm::length(camera_.target - camera_.eye);
}

void Navigator::press(Drag drag, const glm::dvec2& px, std::optional<double> depth, double time_s) {
    drag_ = drag;
    last_px_ = px;
    drag_depth_ = depth.value_or(depth_of_target());
    spin_.hold(time_s);
    if (drag == Drag::light) move_to(px, time_s);
}

void Navigator::move_to(const glm::dvec2& px, double time_s) {
    const geom::View view = geom::make_view(camera_, width_, height_);
    switch (drag_) {
        case Drag::none:
            return;
        case Drag::turn: {
            const Turn turn = turn_between(last_px_, px, width_, height_);
            change(turned(camera_, turn.axis, turn.angle), time_s);
            spin_.drag(turn, time_s);
            break;
        }
        case Drag::pan:
            // What was under the mouse stays under it.
            change(moved(camera_, point_at(view, last_px_.x, last_px_.y, drag_depth_) -
                                      point_at(view, px.x, px.y, drag_depth_)),
                   time_s);
            break;
        case Drag::dolly:
            change(approached(camera_, camera_.target,
                              std::exp(0.5 * kDollyPerHeight * (px.y - last_px_.y) / height_), nearest_),
                   time_s);
            break;
        case Drag::light: {
            const glm::dvec3 ball = on_ball(px, width_, height_);
            key_light_ = ball.x * view.right + ball.y * view.down + ball.z * view.forward;
            break;
        }
    }
    last_px_ = px;
}

void Navigator::release(double time_s) {
    if (drag_ == Drag::turn)
        spin_.let_go(time_s);
    else
        stop();
    drag_ = Drag::none;
}

void Navigator::zoom(const glm::dvec2& px, std::optional<double> depth, double notches, double time_s) {
    const geom::View view = geom::make_view(camera_, width_, height_);
    const glm::dvec3 point = point_at(view, px.x, px.y, depth.value_or(depth_of_target()));
    change(approached(camera_, point, std::pow(kNotch, notches), nearest_), time_s);
}

void Navigator::widen(double steps, double time_s) {
    change(widened(camera_, std::pow(kWideningStep, steps)), time_s);
}

void Navigator::turn(double right_deg, double up_deg, double time_s) {
    constexpr double kRadians = std::numbers::pi / 180;
    stop();
    change(turned(turned(camera_, {0, 1, 0}, -right_deg * kRadians), {1, 0, 0}, -up_deg * kRadians), time_s);
}

bool Navigator::aim(const glm::dvec2& px, std::optional<double> depth, double time_s) {
    if (!depth) return false;
    const geom::View view = geom::make_view(camera_, width_, height_);
    jump_to(aimed(camera_, point_at(view, px.x, px.y, *depth)), time_s);
    return true;
}

bool Navigator::go_to_view(size_t number, double time_s) {
    if (!saved_[number]) return false;
    jump_to(*saved_[number], time_s);
    return true;
}

void Navigator::step(double time_s) {
    const Turn turn = spin_.step(time_s);
    if (turn.angle > 0) change(turned(camera_, turn.axis, turn.angle), time_s);
}

bool Navigator::is_moving(double time_s) const {
    return spin_.is_spinning() || time_s - moved_s_ < kRest_s;
}

}  // namespace view
