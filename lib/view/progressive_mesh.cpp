// A progressive mesh as it is looked at, from a file or a server.
//
// The mesh for a camera is made in a thread of its own, which may wait for a server; whoever draws shows the
// newest one, from wherever the camera is by now.
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "core/stopwatch.h"
#include "scene/progressive.h"
#include "view/feedback.h"
#include "view/refinement_share.h"
#include "view/subject.h"

namespace view {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPatience_s = 0.05;  // for what a server sends, until a mesh of what has come is shown
constexpr double kSilence_s = 2;      // of a server, until the user is told
constexpr int kNeverGiveUp = 1'000'000'000;

// A mesh, and what it was made for.
struct MadeMesh {
    mesh::Mesh mesh;
    double threshold_px = 0;
    uint64_t wanted = 0;  // the number of the wish
    bool is_complete = false;
    uint64_t bytes_down = 0;  // by then
};

class Maker {
  public:
    // The source is used by the maker alone from now on.
    explicit Maker(std::unique_ptr<scene::ProgressiveSource> source)
        : source_(std::move(source)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

    void want(const Wish& wish, double threshold_px, uint64_t number) {
        const std::lock_guard lock(mutex_);
        wish_ = wish, threshold_px_ = threshold_px, number_ = number;
        changed_.notify_all();
    }
    std::shared_ptr<const MadeMesh> newest() const {
        const std::lock_guard lock(mutex_);
        return newest_;
    }
    // What is wrong, if anything.
    std::string trouble() const {
        const std::lock_guard lock(mutex_);
        if (!failure_.empty()) return failure_;
        const bool is_silent = is_busy_ && Clock::now() - begun_ > std::chrono::duration<double>(kSilence_s);
        return is_silent ? "the server does not answer; what has come is shown" : "";
    }
    bool has_failed() const {
        const std::lock_guard lock(mutex_);
        return !failure_.empty();
    }

  private:
    void run(const std::stop_token& stop) {
        uint64_t bytes_down = 0;
        try {
            while (wait_for_work(stop)) {
                auto made = std::make_shared<MadeMesh>();
                const Wish wish = begin(*made);
                scene::ProgressiveCosts costs;
                made->mesh = source_->mesh_for(wish.camera, wish.width, wish.height, made->threshold_px,
                                               costs, kPatience_s);
                made->is_complete = costs.is_complete;
                made->bytes_down = bytes_down += costs.bytes_down;
                const std::lock_guard lock(mutex_);
                newest_ = std::move(made);
                is_busy_ = false;
            }
        } catch (const core::Error& error) {
            const std::lock_guard lock(mutex_);
            failure_ = error.what();
        }
    }

    bool wait_for_work(const std::stop_token& stop) {
        std::unique_lock lock(mutex_);
        return changed_.wait(lock, stop, [&] {
            return number_ > 0 && (!newest_ || newest_->wanted != number_ || !newest_->is_complete);
        });
    }

    Wish begin(MadeMesh& made) {
        const std::lock_guard lock(mutex_);
        made.threshold_px = threshold_px_, made.wanted = number_;
        is_busy_ = true, begun_ = Clock::now();
        return wish_;
    }

    std::unique_ptr<scene::ProgressiveSource> source_;
    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    Wish wish_;
    double threshold_px_ = 0;
    uint64_t number_ = 0;
    std::shared_ptr<const MadeMesh> newest_;
    std::string failure_;
    bool is_busy_ = false;
    Clock::time_point begun_;
    std::jthread thread_;  // last: it uses the others
};

class ProgressiveMesh final : public Subject {
  public:
    ProgressiveMesh(std::unique_ptr<scene::ProgressiveSource> source, bool is_remote,
                    const SubjectOptions& options)
        : bounds_(source->bounds()),
          outline_(source->outline()),
          is_remote_(is_remote),
          backend_(scene::open_backend(options.backend)),
          maker_(std::move(source)) {}

    geom::Sphere bounds() const override { return bounds_; }
    std::vector<geom::Sphere> outline() const override { return outline_; }
    std::string describe() const override { return backend_.name + ": " + backend_.is; }
    bool is_arriving() const override { return !maker_.has_failed() && (is_remote_ || !is_final_); }

    PictureReport draw(const Wish& wish, render::Frame& frame) override {
        want(wish);
        shown_ = maker_.newest();
        core::Stopwatch watch;
        draw_shown(geom::make_view(wish.camera, wish.width, wish.height), wish, frame);
        const double draw_ms = watch.lap_ms();
        if (shown_ && wish.is_moving) feedback_.learn(shown_->threshold_px, draw_ms, wish.budget_ms);
        told_trouble_ = maker_.trouble();
        const PictureReport made = report(draw_ms);
        is_final_ = made.is_final;
        return made;
    }

    void draw_part(const geom::View& view, const Wish& wish, render::Frame& frame) override {
        draw_shown(view, wish, frame);
    }

    bool has_more(const Wish& wish) override {
        want(wish);
        return maker_.newest() != shown_ || maker_.trouble() != told_trouble_;
    }

  private:
    // A camera at rest is shown all that it wants, one that moves what can be drawn in time.
    void want(const Wish& wish) {
        const double threshold_px =
            wish.is_moving ? feedback_.threshold_px(wish.threshold_px) : wish.threshold_px;
        const bool is_new = !last_ || !show_the_same(*last_, wish);
        if (!is_new && (wish.is_moving || threshold_px == wanted_px_)) return;
        last_ = wish, wanted_px_ = threshold_px;
        maker_.want(wish, threshold_px, ++number_);
    }

    void draw_shown(const geom::View& view, const Wish& wish, render::Frame& frame) {
        static const mesh::Mesh kNothing;
        scene::draw_mesh(shown_ ? shown_->mesh : kNothing, view, wish.look, *backend_.painter, frame);
    }

    PictureReport report(double draw_ms) const {
        PictureReport r;
        r.draw_ms = draw_ms;
        r.error_bound_px = std::numeric_limits<double>::infinity();  // measured, not proven: pm(5)
        r.trouble = told_trouble_;
        r.refinement = 0;
        if (!shown_) return r;
        r.threshold_px = shown_->threshold_px;
        r.triangles = shown_->mesh.triangles.size();
        r.is_final = shown_->is_complete && shown_->wanted == number_ && wanted_px_ == last_->threshold_px;
        r.refinement = r.is_final ? 1 : refinement_share(shown_->threshold_px, last_->threshold_px);
        if (is_remote_) r.arrival = {shown_->bytes_down, 0, shown_->is_complete ? 1.0 : 0.0};
        return r;
    }

    geom::Sphere bounds_;
    std::vector<geom::Sphere> outline_;
    bool is_remote_;
    scene::Backend backend_;
    Feedback feedback_;
    std::shared_ptr<const MadeMesh> shown_;
    std::string told_trouble_;
    bool is_final_ = false;  // the last picture
    std::optional<Wish> last_;
    double wanted_px_ = 0;
    uint64_t number_ = 0;
    Maker maker_;  // last: its thread ends first
};

}  // namespace

std::unique_ptr<Subject> open_progressive_mesh(const std::string& source, const SubjectOptions& options) {
    const bool is_remote = source.starts_with("pm:");
    return std::make_unique<ProgressiveMesh>(scene::open_progressive(source, kNeverGiveUp), is_remote,
                                             options);
}

}  // namespace view
