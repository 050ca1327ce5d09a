// The points of a sampling server as they are looked at.
#include <algorithm>
#include <chrono>
#include <limits>

#include "core/error.h"
#include "ppve/client.h"
#include "ppve/client/reconstruction.h"
#include "ppve/link.h"
#include "view/subject.h"

namespace view {

namespace {

using Clock = std::chrono::steady_clock;

class Points final : public Subject {
  public:
    Points(const std::string& source, const ppve::ClientOptions& options)
        : client_(
              [source, timeout_s = options.answer_timeout_s] {
                  return ppve::is_session_file(source) ? ppve::replay(source)
                                                       : ppve::connect_to_server(source, timeout_s);
              },
              options),
          box_(client_.wait_for_bounds()) {}

    geom::Sphere bounds() const override { return box_.sphere(); }
    std::vector<geom::Sphere> outline() const override {
        const auto corners = box_.corners();
        return {corners.begin(), corners.end()};
    }
    std::string describe() const override { return "cpu: points of a server, in two steps"; }
    bool is_arriving() const override { return true; }

    PictureReport draw(const Wish& wish, render::Frame& frame) override {
        const geom::View view = geom::make_view(wish.camera, wish.width, wish.height);
        look(wish, view);
        shown_ = client_.model();
        was_settled_ = client_.is_settled() && !wish.is_moving;
        std::vector<uint8_t> seen;
        const ppve::ReconstructionCounts drawn = draw_shown(view, wish, frame, &seen);
        client_.note_drawn(*shown_, seen);
        told_trouble_ = trouble();
        PictureReport r;
        r.error_bound_px = std::numeric_limits<double>::infinity();
        r.splats = drawn.points_drawn;
        r.draw_ms = drawn.select_ms + drawn.draw_ms;
        r.is_final = was_settled_;
        r.arrival = {client_.counts().bytes_received, 0, was_settled_ ? 1.0 : 0.0};
        r.trouble = told_trouble_;
        return r;
    }

    void draw_part(const geom::View& view, const Wish& wish, render::Frame& frame) override {
        draw_shown(view, wish, frame, nullptr);
    }

    bool has_more(const Wish& wish) override {
        if (last_ && last_->is_moving != wish.is_moving)
            look(wish, geom::make_view(wish.camera, wish.width, wish.height));
        return client_.model() != shown_ || (!wish.is_moving && client_.is_settled() != was_settled_) ||
               trouble() != told_trouble_;
    }

  private:
    void look(const Wish& wish, const geom::View& view) {
        ppve::Gaze gaze;
        gaze.time_s = std::chrono::duration<double>(Clock::now() - start_).count();
        gaze.camera = wish.camera;
        gaze.eyes = {view};
        gaze.is_still = !wish.is_moving;
        client_.look(gaze);
        last_ = wish;
    }

    ppve::ReconstructionCounts draw_shown(const geom::View& view, const Wish& wish, render::Frame& frame,
                                          std::vector<uint8_t>* seen) {
        ppve::ReconstructionOptions options;
        options.scale = was_settled_ ? 1 : ppve::kScaleInMotion;
        options.look = wish.look;
        return reconstruction_.draw(*shown_, {&view, 1}, options, {&frame, 1}, seen).front();
    }

    // From a failure until a server has answered again.
    std::string trouble() {
        const ppve::ClientCounts counts = client_.counts();
        if (counts.failures > failures_) failures_ = counts.failures, updates_ = counts.updates;
        const bool is_lost = failures_ > 0 && counts.updates == updates_;
        return is_lost ? "the server is asked again and again: " + counts.failure : "";
    }

    // Of the last failure: how many there had been, and how many answers.
    uint64_t failures_ = 0, updates_ = 0;
    ppve::Client client_;
    ppve::Box box_;
    ppve::Reconstruction reconstruction_;
    std::shared_ptr<const ppve::PointModel> shown_;
    bool was_settled_ = false;
    std::string told_trouble_;
    std::optional<Wish> last_;
    Clock::time_point start_ = Clock::now();
};

}  // namespace

std::unique_ptr<Subject> open_points(const std::string& source, const SubjectOptions& options) {
    ppve::ClientOptions client;
    client.width = options.width, client.height = options.height;
    client.wants_normals = true;
    return std::make_unique<Points>(source, client);
}

}  // namespace view
