// budget_bench MODEL PATH: draws a path within a budget, once as qs-render --budget does and once by feedback
// alone, as the original program did.  Prints a JSON line for each: how many frames were in time, and what
// they held. What it measures are times: see that the machine does nothing else.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "geom/camera.h"
#include "scene/budget_painter.h"

namespace {

using core::Json;

struct Job {
    std::string model, path;
    double budget_ms = 33, threshold_px = 1;
    std::array<double, 2> size{1280, 720};
};

struct Drawn {
    double ms = 0, predicted_ms = 0, threshold_px = 0;
    uint64_t splats = 0;
};

// Studied in QSplat 1.0: thresholds from 1 to 50 pixels, from 50 on; slower to fall than to rise.
class Feedback {
  public:
    explicit Feedback(double budget_ms) : budget_ms_(budget_ms) {}

    double threshold_px(double finest_px) const { return std::max(finest_px, threshold_px_); }
    void learn(double ms) {
        const double part = ms / budget_ms_;
        threshold_px_ *= std::sqrt(std::pow(part, part > 1 ? 1.25 : 0.75));
        threshold_px_ = std::clamp(threshold_px_, 0.01, 50.0);
    }

  private:
    double budget_ms_, threshold_px_ = 50;
};

double at_part(std::vector<double> values, double part) {
    std::sort(values.begin(), values.end());
    return values[size_t(part * double(values.size() - 1) + 0.5)];
}

template <class Of>
std::vector<double> all_of(const std::vector<Drawn>& frames, const Of& of) {
    std::vector<double> values;
    for (const Drawn& frame : frames) values.push_back(of(frame));
    return values;
}

Json summary(const std::string& method, const Job& job, const std::vector<Drawn>& frames) {
    const std::vector<double> ms = all_of(frames, [](const Drawn& f) { return f.ms; });
    const auto late = [&](double budgets) {
        return double(
            std::count_if(ms.begin(), ms.end(), [&](double m) { return m > budgets * job.budget_ms; }));
    };
    const double count = double(frames.size());
    return {
        {"method", method},
        {"budget_ms", job.budget_ms},
        {"frames", frames.size()},
        {"share_in_time", 1 - late(scene::FrameBudget::kTolerance) / count},
        {"first_ms", ms.front()},
        {"median_ms", at_part(ms, 0.5)},
        {"p95_ms", at_part(ms, 0.95)},
        {"max_ms", at_part(ms, 1)},
        {"median_off_prediction", at_part(all_of(frames,
                                                 [](const Drawn& f) {
                                                     return f.predicted_ms > 0
                                                                ? std::abs(f.ms / f.predicted_ms - 1)
                                                                : 0;
                                                 }),
                                          0.5)},
        {"median_threshold_px", at_part(all_of(frames, [](const Drawn& f) { return f.threshold_px; }), 0.5)},
        {"median_splats", at_part(all_of(frames, [](const Drawn& f) { return double(f.splats); }), 0.5)}};
}

void run(const Job& job) {
    const splat::Model model(job.model);
    const core::InputFile file(job.path);
    const std::vector<geom::Camera> path = geom::parse_path(
        {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}, file.name());
    const auto film = [&](const std::string& method, const auto& draw) {
        std::vector<Drawn> frames;
        for (const geom::Camera& camera : path)
            frames.push_back(draw(geom::make_view(camera, int(job.size[0]), int(job.size[1]))));
        core::print(summary(method, job, frames).dump() + "\n");
    };
    render::Frame frame;
    scene::DrawOptions options;
    options.cut.threshold_px = job.threshold_px;

    scene::ModelPainter predicting(model);
    scene::BudgetPainter painter(predicting, job.budget_ms);
    film("prediction", [&](const geom::View& view) {
        scene::DrawOptions chosen = options;
        const scene::DrawReport drawn = painter.draw(view, chosen, frame);
        const scene::BudgetReport& report = painter.report();
        return Drawn{report.predict_ms + drawn.traverse_ms + drawn.draw_ms, report.predicted_ms,
                     chosen.cut.threshold_px, drawn.counts.splats};
    });

    scene::ModelPainter following(model);
    Feedback feedback(job.budget_ms);
    film("feedback alone", [&](const geom::View& view) {
        scene::DrawOptions chosen = options;
        chosen.cut.threshold_px = feedback.threshold_px(job.threshold_px);
        const scene::DrawReport drawn = following.draw(view, chosen, frame);
        const double ms = drawn.traverse_ms + drawn.draw_ms;
        feedback.learn(ms);
        return Drawn{ms, 0, chosen.cut.threshold_px, drawn.counts.splats};
    });
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("budget_bench", "Draw a path within a budget, by prediction and by feedback alone.",
                          QS_VERSION);
    Job job;
    program.options.add_option("MODEL", job.model, "Splat model")->required();
    program.options.add_option("PATH", job.path, "Camera path")->required();
    program.add_duration("--budget", job.budget_ms, 0.001, 3.6e6, "Time for a frame");
    program.add_number("--threshold", job.threshold_px, 0, 1e6, "pixels", "The finest threshold");
    program.add_numbers("--resolution", job.size, "W,H", "Size of the picture");
    return program.run(argc, argv, [&] { run(job); });
}
