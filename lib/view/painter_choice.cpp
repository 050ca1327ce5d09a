#include "view/painter_choice.h"

#include <utility>

#include "core/error.h"

namespace view {

std::vector<scene::Backend> backends_to_choose_from(scene::BackendKind kind) {
    std::vector<scene::Backend> backends;
    backends.push_back(scene::open_backend(kind));
    if (kind == scene::BackendKind::automatic && backends.front().name != "cpu")
        backends.push_back(scene::open_backend(scene::BackendKind::cpu));
    return backends;
}

ChosenPainter fastest_painter(const std::vector<scene::PlacedModel>& models,
                              std::vector<scene::Backend> backends,
                              const std::function<double(scene::ModelPainter&)>& measure_ms) {
    ChosenPainter best;
    double best_ms = 0;
    std::string times;
    for (scene::Backend& backend : backends) {
        ChosenPainter candidate{std::make_unique<scene::ModelPainter>(models, std::move(backend.painter)),
                                backend.name + ": " + backend.is};
        if (backends.size() == 1) return candidate;
        const double ms = measure_ms(*candidate.painter);
        times += core::text("%s%s %.1f ms", times.empty() ? "" : ", ", backend.name.c_str(), ms);
        if (best.painter && ms >= best_ms) continue;
        best = std::move(candidate), best_ms = ms;
    }
    best.description += " (a frame: " + times + ")";
    return best;
}

}  // namespace view
