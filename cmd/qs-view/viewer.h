// The viewer: joins the window, the camera, and the session that draws.
//
// One thread, which waits for nothing but the window's events.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "qs-view/arguments.h"
#include "qs-view/canvas.h"
#include "qs-view/errands.h"
#include "qs-view/overlay.h"
#include "qs-view/window.h"
#include "view/meter.h"
#include "view/navigator.h"
#include "view/recording.h"
#include "view/session.h"

namespace qs_view {

class Viewer final : private Events {
  public:
    explicit Viewer(const Arguments& arguments);

    // Until the window is closed.  Throws what kept the sources of the command line from being opened.
    void run();

  private:
    void pressed(int button, const glm::dvec2& px, const Modifiers& with) override;
    void released(int button) override;
    void moved(const glm::dvec2& px) override;
    void wheeled(double notches) override;
    void key(int key, const Modifiers& with, bool is_repeat) override;
    void character(unsigned code) override;
    void dropped(std::vector<std::string> files) override;

    void open(const std::vector<std::string>& sources);
    void leave();
    void step();
    void take_news();
    void take_failure(const std::exception_ptr& failure);
    void meet(const view::Opened& opened);
    void look();
    void draw();
    OverlayContent overlay_content(double now_s);
    std::string message() const;
    void note(const std::string& text);

    std::optional<double> depth_at(const glm::dvec2& px) const;
    std::optional<view::Lens> lens() const;
    void aim(const glm::dvec2& px);
    void toggle_shade(render::Shade shade);
    void toggle_recording();
    void end_recording();
    void save_view(size_t number);
    void save_picture(const std::string& name);
    void print_camera() const;
    bool is_restless(double now_s) const;
    void report();

    const Arguments& a_;
    Window window_;
    gl::Use gl_;
    Canvas canvas_;
    Overlay overlay_;
    Errands errands_;
    std::vector<std::string> sources_;
    std::unique_ptr<view::Session> session_;
    std::vector<std::unique_ptr<view::Session>> left_;  // of sources that were left, which may wait still
    std::shared_ptr<const view::Opened> opened_;
    std::shared_ptr<const view::Picture> picture_;
    view::Navigator navigator_;
    render::Look look_;
    double threshold_px_, budget_ms_;
    std::optional<view::Recording> recording_;
    std::string record_;                       // the file for it; empty: a new one
    std::optional<geom::Camera> kept_camera_;  // for a source that is opened anew
    view::Meter pictures_, fetched_;
    bool shows_status_, shows_keys_ = false, has_opened_once_ = false, is_picture_taken_ = false;
    bool is_failure_told_ = false;
    bool was_final_ = false;
    // For the report.
    core::Report report_;
    uint64_t frames_ = 0;
    double longest_turn_s_ = 0;
    std::optional<double> opened_s_, first_picture_s_, complete_s_;
    std::string note_;
    double note_until_s_ = 0, pressed_s_ = -1;
};

}  // namespace qs_view
