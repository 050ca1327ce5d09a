// The virtual trackball: what a way of the mouse turns, and how it goes on turning when let go.
//
// A ball as wide as the smaller side of the picture, which far from its middle goes over into a hyperbola, so
// that turning is smooth everywhere (G. Bell's; Henriksen, Sporring, Hornbaek, Virtual trackballs revisited,
// 2004).
#pragma once

#include <glm/glm.hpp>

namespace view {

// About a unit axis in view space (x right, y down, z forward), radians; angle 0: none.
struct Turn {
    glm::dvec3 axis{0, 1, 0};
    double angle = 0;
};

// The ball's point under a place in a picture of width x height pixels, view space, unit length, z <= 0.
glm::dvec3 on_ball(const glm::dvec2& px, int width, int height);

// How the camera turns about its target so that what was on the ball under `from` comes under `to`.
Turn turn_between(const glm::dvec2& from, const glm::dvec2& to, int width, int height);

// A ball that was let go while it turned: it goes on, slower and slower.  Times in seconds, of one clock.
class Spin {
  public:
    // A hand on the ball: it stops, and learns from each turn how fast it is.
    void hold(double time_s);
    void drag(const Turn& turn, double time_s);
    void let_go(double time_s);

    // The turn from the last step (or from letting go) to now; of angle 0 where it rests.
    Turn step(double time_s);
    bool is_spinning() const { return speed_ != 0 && !is_held_; }

  private:
    bool is_held_ = false;
    glm::dvec3 axis_{0, 1, 0};
    double speed_ = 0;  // radians a second
    double last_s_ = 0;
};

}  // namespace view
