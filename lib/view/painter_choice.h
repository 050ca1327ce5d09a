// Which back end draws what is looked at: the one that was asked for, or, where there is a graphics
// processor, that one of it and the processor that draws the first view faster.  Which it is depends on the
// model and on both, and a picture of the graphics processor has to come back before it is shown.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scene/backends.h"
#include "scene/draw.h"

namespace view {

// What `kind` leaves to choose from: automatic, where there is a graphics processor, it and the processor;
// else one. Throws as scene::open_backend().
std::vector<scene::Backend> backends_to_choose_from(scene::BackendKind kind);

struct ChosenPainter {
    std::unique_ptr<scene::ModelPainter> painter;
    std::string description;  // which, and how long each took where it was measured; for people
};

// Of `backends`, one at least, the one with which `measure_ms` takes least time; of equals the first.  Of a
// single one nothing is measured.
ChosenPainter fastest_painter(const std::vector<scene::PlacedModel>& models,
                              std::vector<scene::Backend> backends,
                              const std::function<double(scene::ModelPainter&)>& measure_ms);

}  // namespace view
