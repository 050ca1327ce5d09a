#include "qs-view/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "render/image.h"
#include "view/status.h"

namespace qs_view {

using core::text;

namespace {

constexpr double kFrame_s = 1.0 / 60;  // while something moves
constexpr double kIdle_s = 0.25;       // else; a picture that is ready ends it
constexpr double kNote_s = 4;          // that a note is shown
constexpr double kDoubleClick_s = 0.3;
constexpr double kTurnDeg = 5;  // a press of an arrow
constexpr double kFinerFactor = 0.70710678118654752;
constexpr double kLeastThreshold_px = 0.05, kMostThreshold_px = 64, kLeastBudget_ms = 4, kMostBudget_ms = 500;
constexpr double kBudgetFactor = 1.25;

std::string message_of(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& error) {
        return error.what();
    }
}

}  // namespace

Viewer::Viewer(const Arguments& arguments)
    : a_(arguments),
      window_("qs-view", int(a_.resolution[0]), int(a_.resolution[1]), *this),
      gl_(window_.device()),
      canvas_(gl_),
      overlay_(window_.scale()),
      errands_(&Window::wake),
      look_(look_of(a_)),
      threshold_px_(a_.threshold_px),
      budget_ms_(a_.budget_ms),
      record_(a_.record),
      pictures_(0.5),
      fetched_(2),
      shows_status_(!a_.hide_status),
      report_(a_.sources, {a_.record, a_.screenshot}) {
    navigator_.set_key_light(look_.key_light);
    core::notice("window: " + window_.device().renderer() + ", " + window_.device().version());
    if (!a_.sources.empty()) open(a_.sources);
    if (!a_.record.empty()) toggle_recording();
}

void Viewer::run() {
    while (!window_.is_closing()) {
        const double now_s = Window::time_s();
        window_.wait(is_restless(now_s) ? kFrame_s : kIdle_s);
        const double begin_s = Window::time_s();
        step();
        if (!window_.is_iconified()) draw();
        longest_turn_s_ = std::max(longest_turn_s_, Window::time_s() - begin_s);
    }
    if (recording_) end_recording();
    leave();
    left_.clear();
    errands_.finish();
    report();
    if (!a_.screenshot.empty() && !is_picture_taken_)
        throw core::Error(a_.screenshot + ": the window was closed before the picture was complete");
}

void Viewer::report() {
    if (!report_.is_wanted()) return;
    const auto or_null = [](const std::optional<double>& time_s) {
        return time_s ? core::Json(*time_s) : core::Json();
    };
    core::Json json;
    json["frames"] = frames_;
    json["longest_frame_ms"] = 1000 * longest_turn_s_;
    json["pictures"] = picture_ ? picture_->number : 0;
    json["opened_s"] = or_null(opened_s_);
    json["first_picture_s"] = or_null(first_picture_s_);
    json["complete_s"] = or_null(complete_s_);
    report_.write(json);
    report_.commit();
}

bool Viewer::is_restless(double now_s) const {
    return navigator_.is_moving(now_s) || recording_ || !opened_;
}

void Viewer::open(const std::vector<std::string>& sources) {
    if (recording_ && opened_) end_recording();  // which is of what was open
    leave();
    opened_.reset(), picture_.reset();
    is_failure_told_ = false;
    pictures_ = view::Meter(0.5), fetched_ = view::Meter(2);
    was_final_ = false;
    sources_ = sources;
    view::SubjectOptions options = subject_options(a_);
    const glm::ivec2 size = window_.size_px();
    options.width = size.x, options.height = size.y;
    // The command line's camera is that of its own sources.
    session_ = std::make_unique<view::Session>(
        sources, options, has_opened_once_ ? scene::CameraOptions() : a_.camera, &Window::wake);
    window_.set_title("qs-view: " + session_->name());
}

// Which may take as long as a disk or a server.
void Viewer::leave() {
    if (!session_) return;
    session_->close();
    left_.push_back(std::move(session_));
}

void Viewer::step() {
    const double now_s = Window::time_s();
    const glm::ivec2 size = window_.size_px();
    navigator_.resize(size.x, size.y);
    std::erase_if(left_, [](const auto& session) { return session->has_ended(); });
    take_news();
    navigator_.step(now_s);
    if (recording_ && opened_) recording_->note(navigator_.camera(), now_s);
    look();
}

void Viewer::take_news() {
    for (const std::string& line : errands_.news()) note(line);
    if (is_picture_taken_ && errands_.are_done()) return window_.close();
    if (!session_) return;
    if (const std::exception_ptr failure = session_->failure()) take_failure(failure);
    if (!opened_ && (opened_ = session_->opened())) meet(*opened_);
    const std::shared_ptr<const view::Picture> newest = session_->picture();
    if (!newest || newest == picture_) return;
    picture_ = newest;
    const double now_s = Window::time_s();
    if (!first_picture_s_) first_picture_s_ = now_s;
    pictures_.note(double(picture_->number), now_s);
    if (picture_->report.arrival) fetched_.note(double(picture_->report.arrival->bytes_fetched), now_s);
    const bool is_final = picture_->report.is_final && !navigator_.is_moving(now_s);
    if (is_final && !was_final_) core::notice("picture complete");
    if (is_final && !complete_s_) complete_s_ = now_s;
    was_final_ = is_final;
    if (is_final && !a_.screenshot.empty() && !is_picture_taken_) {
        save_picture(a_.screenshot);
        is_picture_taken_ = true;
    }
}

// Of the command line's sources there is nothing to be seen then; of others the window says it, too.
void Viewer::take_failure(const std::exception_ptr& failure) {
    if (!has_opened_once_ || !a_.screenshot.empty()) std::rethrow_exception(failure);
    if (!is_failure_told_) core::warn(message_of(failure));
    is_failure_told_ = true;
}

void Viewer::meet(const view::Opened& opened) {
    core::notice(text("opened %s in %.2f s; drawn by ", session_->name().c_str(), opened.opening_s) +
                 opened.description);
    const std::optional<glm::dvec3> light = navigator_.key_light();
    // Opened anew, it has those views that are still being written, too.
    const view::SavedViews views = kept_camera_ ? navigator_.views() : opened.views;
    navigator_ = view::Navigator(opened.home, opened.bounds);
    navigator_.set_key_light(light);
    navigator_.set_views(views);
    if (!opened.views_trouble.empty()) core::warn(opened.views_trouble);
    const glm::ivec2 size = window_.size_px();
    navigator_.resize(size.x, size.y);
    if (kept_camera_) navigator_.jump_to(*kept_camera_, Window::time_s());
    kept_camera_.reset();
    has_opened_once_ = true;
    if (!opened_s_) opened_s_ = Window::time_s();
    if (recording_) recording_.emplace(Window::time_s());
}

void Viewer::look() {
    if (!opened_) return;
    view::Wish wish;
    wish.camera = navigator_.camera();
    wish.width = navigator_.width(), wish.height = navigator_.height();
    wish.look = look_;
    wish.look.key_light = navigator_.key_light();
    wish.threshold_px = threshold_px_;
    wish.budget_ms = budget_ms_;
    wish.is_moving = navigator_.is_moving(Window::time_s());
    wish.lens = lens();
    session_->look(wish);
}

void Viewer::draw() {
    const glm::ivec2 size = window_.size_px();
    canvas_.clear(size, look_.background);
    if (picture_) {
        canvas_.put(*picture_);
        if (picture_->lens && lens()) canvas_.put_lens(*picture_->lens, window_.mouse_px());
    }
    overlay_.draw(overlay_content(Window::time_s()), size);
    window_.show_frame();
    ++frames_;
}

OverlayContent Viewer::overlay_content(double now_s) {
    OverlayContent content;
    content.has_keys = shows_keys_;
    content.is_recording = recording_.has_value();
    content.message = message();
    if (now_s < note_until_s_) content.note = note_;
    if (!picture_ || !shows_status_) return content;
    const view::PictureReport& report = picture_->report;
    if (look_.shade == render::Shade::level) content.legend = view::legend(report);
    content.status = view::status_line(report, {pictures_.rate(now_s), fetched_.rate(now_s)});
    if (!report.trouble.empty()) content.note = report.trouble;
    if (!navigator_.is_moving(now_s)) content.refinement = report.refinement;
    if (report.arrival && !report.is_final) content.download = report.arrival->part_there;
    return content;
}

std::string Viewer::message() const {
    if (!session_) return "Drop a model here.  F1 shows the keys.";
    if (const std::exception_ptr failure = session_->failure()) return message_of(failure);
    return opened_ ? "" : "opening " + session_->name() + " ...";
}

void Viewer::note(const std::string& words) {
    note_ = words;
    note_until_s_ = Window::time_s() + kNote_s;
}

// Of the picture that is shown, which may be of another size.
std::optional<double> Viewer::depth_at(const glm::dvec2& px) const {
    if (!picture_ || picture_->frame.width != navigator_.width() ||
        picture_->frame.height != navigator_.height())
        return {};
    return picture_->depth_at(px);
}

std::optional<view::Lens> Viewer::lens() const {
    if (!window_.is_key_down(GLFW_KEY_M)) return {};
    view::Lens lens;
    lens.centre_px = window_.mouse_px();
    return lens;
}

void Viewer::pressed(int button, const glm::dvec2& px, const Modifiers& with) {
    if (!opened_) return;
    const double now_s = Window::time_s();
    const bool is_left = button == GLFW_MOUSE_BUTTON_LEFT;
    if (is_left && now_s - pressed_s_ < kDoubleClick_s) return aim(px);
    if (is_left) pressed_s_ = now_s;
    view::Drag drag = is_left ? view::Drag::turn : view::Drag::pan;
    if (is_left && with.shift) drag = view::Drag::pan;
    if (is_left && with.control) drag = view::Drag::dolly;
    if (is_left && window_.is_key_down(GLFW_KEY_L)) drag = view::Drag::light;
    navigator_.press(drag, px, depth_at(px), now_s);
}

void Viewer::released(int) {
    navigator_.release(Window::time_s());
}

void Viewer::moved(const glm::dvec2& px) {
    if (opened_) navigator_.move_to(px, Window::time_s());
}

void Viewer::wheeled(double notches) {
    const glm::dvec2 px = window_.mouse_px();
    if (opened_) navigator_.zoom(px, depth_at(px), notches, Window::time_s());
}

void Viewer::aim(const glm::dvec2& px) {
    if (!navigator_.aim(px, depth_at(px), Window::time_s())) note("nothing there to turn about");
}

void Viewer::dropped(std::vector<std::string> files) {
    kept_camera_.reset();
    open(files);
}

void Viewer::toggle_shade(render::Shade shade) {
    const render::Shade other =
        a_.shade == "level" || a_.shade == "normal" ? render::Shade::lit : look_of(a_).shade;
    look_.shade = look_.shade == shade ? other : shade;
}

void Viewer::toggle_recording() {
    if (recording_) return end_recording();
    recording_.emplace(Window::time_s());
    note("recording; R ends it");
}

// The first one into the file that was asked for, if any was.
void Viewer::end_recording() {
    if (opened_) recording_->end(navigator_.camera(), Window::time_s());
    if (recording_->frames() > 0)
        errands_.write(std::exchange(record_, ""), "jsonl",
                       [recording = *recording_] { return recording.text(); });
    recording_.reset();
}

void Viewer::save_picture(const std::string& name) {
    if (!picture_) return;
    errands_.write(name, "png", [picture = picture_] {
        const std::vector<std::byte> png =
            render::encode_png(picture->frame.rgb.data(), picture->frame.width, picture->frame.height);
        return std::string(reinterpret_cast<const char*>(png.data()), png.size());
    });
}

void Viewer::print_camera() const {
    core::write_standard_output(geom::format_camera(navigator_.camera()), true);
}

// Letters are told by what they mean on the keyboard, see character(); these by where they are.
void Viewer::key(int key, const Modifiers& with, bool) {
    const double now_s = Window::time_s();
    switch (key) {
        case GLFW_KEY_F1:
            shows_keys_ = !shows_keys_;
            return;
        case GLFW_KEY_F5:
            if (opened_) kept_camera_ = navigator_.camera();
            if (!sources_.empty()) open(std::vector<std::string>(sources_));
            return;
        case GLFW_KEY_F11:
            return window_.toggle_full_screen();
        case GLFW_KEY_ESCAPE:
            return shows_keys_ ? void(shows_keys_ = false) : window_.close();
        default:
            break;
    }
    if (!opened_) return;
    const glm::dvec2 middle(0.5 * navigator_.width(), 0.5 * navigator_.height());
    switch (key) {
        case GLFW_KEY_LEFT:
            return navigator_.turn(-kTurnDeg, 0, now_s);
        case GLFW_KEY_RIGHT:
            return navigator_.turn(kTurnDeg, 0, now_s);
        case GLFW_KEY_UP:
            return navigator_.turn(0, kTurnDeg, now_s);
        case GLFW_KEY_DOWN:
            return navigator_.turn(0, -kTurnDeg, now_s);
        case GLFW_KEY_HOME:
            return navigator_.go_home(now_s);
        case GLFW_KEY_KP_ADD:
            return navigator_.zoom(middle, depth_at(middle), 1, now_s);
        case GLFW_KEY_KP_SUBTRACT:
            return navigator_.zoom(middle, depth_at(middle), -1, now_s);
        case GLFW_KEY_PAGE_UP:
            threshold_px_ = std::max(threshold_px_ * kFinerFactor, kLeastThreshold_px);
            return note(text("at rest: %.3g px", threshold_px_));
        case GLFW_KEY_PAGE_DOWN:
            threshold_px_ = std::min(threshold_px_ / kFinerFactor, kMostThreshold_px);
            return note(text("at rest: %.3g px", threshold_px_));
        default:
            break;
    }
    const int digit = key - GLFW_KEY_1;
    if (digit < 0 || digit >= int(view::SavedViews().size())) return;
    if (with.control || with.shift)
        save_view(size_t(digit));
    else if (!navigator_.go_to_view(size_t(digit), now_s))
        note(text("no view %d; ctrl %d saves one", digit + 1, digit + 1));
}

// Kept for the next window too, where there is a place for it.
void Viewer::save_view(size_t number) {
    navigator_.save_view(number);
    if (opened_->views_folder.empty())
        return note(text("view %zu saved, until the window is closed: ", number + 1) +
                    opened_->views_trouble);
    errands_.add([folder = opened_->views_folder, number, camera = navigator_.camera()] {
        return view::write_view(folder, number, camera);
    });
}

void Viewer::character(unsigned code) {
    const double now_s = Window::time_s();
    switch (code) {
        case 'q':
            return window_.close();
        case 'i':
            shows_status_ = !shows_status_;
            return;
        default:
            break;
    }
    if (!opened_) return;
    const glm::dvec2 middle(0.5 * navigator_.width(), 0.5 * navigator_.height());
    switch (code) {
        case '+':
            return navigator_.zoom(middle, depth_at(middle), 1, now_s);
        case '-':
            return navigator_.zoom(middle, depth_at(middle), -1, now_s);
        case '[':
            return navigator_.widen(-1, now_s);
        case ']':
            return navigator_.widen(1, now_s);
        case 'c':
            return toggle_shade(render::Shade::level);
        case 'n':
            return toggle_shade(render::Shade::normal);
        case 'k':
            return navigator_.set_key_light(std::nullopt);
        case 'h':
            return navigator_.go_home(now_s);
        case ' ':
            return navigator_.stop();
        case 's':
            return save_picture("");
        case 'r':
            return toggle_recording();
        case 'p':
            return print_camera();
        case ',':
        case '.':
            budget_ms_ = std::clamp(code == ',' ? budget_ms_ * kBudgetFactor : budget_ms_ / kBudgetFactor,
                                    kLeastBudget_ms, kMostBudget_ms);
            return note(text("in motion: %.0f ms a frame", budget_ms_));
        default:
            break;
    }
}

}  // namespace qs_view
