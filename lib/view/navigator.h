// Where the viewer's camera is and where its light comes from: what mouse and keys do to them.
//
// Pure: no window, no clock.  Times are seconds of one clock, places pixels of the picture from its upper
// left corner.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "geom/camera.h"
#include "geom/sphere.h"
#include "view/saved_views.h"
#include "view/trackball.h"

namespace view {

// What a drag of the mouse does.
enum class Drag { none, turn, pan, dolly, light };

class Navigator {
  public:
    // Before there is something to look at.
    Navigator() = default;
    // `home`: where to begin and to come back to.  `bounds`: of what is looked at, world units; says how near
    // is too near.
    Navigator(const geom::Camera& home, const geom::Sphere& bounds);

    const geom::Camera& camera() const { return camera_; }
    // The direction that the light comes from, world space; none: the head light alone.
    const std::optional<glm::dvec3>& key_light() const { return key_light_; }
    void set_key_light(const std::optional<glm::dvec3>& direction) { key_light_ = direction; }

    // Of the picture that places are in.
    void resize(int width, int height) { width_ = width, height_ = height; }
    int width() const { return width_; }
    int height() const { return height_; }

    // `depth`: of the surface under the place, view z in world units; none: where nothing is seen, the
    // target's.
    void press(Drag drag, const glm::dvec2& px, std::optional<double> depth, double time_s);
    void move_to(const glm::dvec2& px, double time_s);
    void release(double time_s);
    Drag drag() const { return drag_; }

    // Nearer to what is under the place by so many notches of a wheel, or farther where they are below 0.
    void zoom(const glm::dvec2& px, std::optional<double> depth, double notches, double time_s);
    // A wider field of view by so many steps, or a narrower one.
    void widen(double steps, double time_s);
    // Turns about the picture's vertical and horizontal axis, degrees.
    void turn(double right_deg, double up_deg, double time_s);
    // From now on turns about what is under the place, which comes to the middle; false where nothing is
    // there.
    bool aim(const glm::dvec2& px, std::optional<double> depth, double time_s);

    void go_home(double time_s) { jump_to(home_, time_s); }
    void set_home(const geom::Camera& home) { home_ = home; }
    // An index of SavedViews.
    void save_view(size_t number) { saved_[number] = camera_; }
    bool go_to_view(size_t number, double time_s);  // false where none was saved
    const SavedViews& views() const { return saved_; }
    void set_views(const SavedViews& views) { saved_ = views; }
    void jump_to(const geom::Camera& camera, double time_s);

    // Lets time pass: a ball that was let go turns on.
    void step(double time_s);
    bool is_spinning() const { return spin_.is_spinning(); }
    void stop() { spin_ = Spin(); }
    // The camera moves, or did so little before that it may go on.
    bool is_moving(double time_s) const;

  private:
    void change(const geom::Camera& camera, double time_s);
    double depth_of_target() const;

    geom::Camera home_{}, camera_{};
    double nearest_ = 0;
    std::optional<glm::dvec3> key_light_;
    int width_ = 1, height_ = 1;
    Drag drag_ = Drag::none;
    glm::dvec2 last_px_{0};
    double drag_depth_ = 0;
    Spin spin_;
    SavedViews saved_{};
    double moved_s_ = -1e9;
};

}  // namespace view
