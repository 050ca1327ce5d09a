#include "view/trackball.h"

#include <algorithm>
#include <cmath>

namespace view {

namespace {

constexpr double kHalving_s = 0.35;      // a spin's speed halves in so long
constexpr double kSlowest = 0.03;        // radians a second: then it rests
constexpr double kHeldStill_s = 0.1;     // a hand that held the ball still for so long lets it go at rest
constexpr double kFastest = 20;          // radians a second
constexpr double kSpeedMemory_s = 0.05;  // of the hand's speed: events come unevenly

}  // namespace

glm::dvec3 on_ball(const glm::dvec2& px, int width, int height) {
    const double radius = 0.5 * std::max(1, std::min(width, height));
    const double x = (px.x - 0.5 * width) / radius, y = (px.y - 0.5 * height) / radius;
    const double d2 = x * x + y * y;
    const double z = d2 < 0.5 ? std::sqrt(1 - d2) : 0.5 / std::sqrt(d2);
    return glm::normalize(glm::dvec3(x, y, -z));
}

Turn turn_between(const glm::dvec2& from, const glm::dvec2& to, int width, int height) {
    const glm::dvec3 a = on_ball(from, width, height), b = on_ball(to, width, height);
    const glm::dvec3 cross = glm::cross(a, b);
    const double sine = glm::length(cross);
    // The model turns from a to b, which is the camera turning from b to a.
    if (!(sine > 0)) return {};
    return {-cross / sine, std::atan2(sine, glm::dot(a, b))};
}

void Spin::hold(double time_s) {
    is_held_ = true;
    speed_ = 0;
    last_s_ = time_s;
}

void Spin::drag(const Turn& turn, double time_s) {
    const double passed_s = std::max(time_s - last_s_, 1e-3);
    last_s_ = time_s;
    const double now = std::min(turn.angle / passed_s, kFastest);
    const double weight = std::exp2(-passed_s / kSpeedMemory_s);
    const glm::dvec3 sum = weight * speed_ * axis_ + (1 - weight) * now * turn.axis;
    speed_ = glm::length(sum);
    if (speed_ > 0) axis_ = sum / speed_;
}

void Spin::let_go(double time_s) {
    is_held_ = false;
    if (time_s - last_s_ > kHeldStill_s || speed_ < kSlowest) speed_ = 0;
    last_s_ = time_s;
}

Turn Spin::step(double time_s) {
    const double passed_s = std::max(time_s - last_s_, 0.0);
    if (!is_spinning()) return {};
    last_s_ = time_s;
    // The way is the integral of the speed, so that it does not depend on how often it is asked for.
    const double rate = std::log(2) / kHalving_s;
    const double slowed = speed_ * std::exp(-rate * passed_s);
    const Turn turn{axis_, (speed_ - slowed) / rate};
    speed_ = slowed < kSlowest ? 0 : slowed;
    return turn;
}

}  // namespace view
