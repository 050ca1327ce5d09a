// The command line of qs-view.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/program.h"
#include "scene/camera_options.h"
#include "view/picture.h"
#include "view/subject.h"

namespace qs_view {

struct Arguments {
    std::vector<std::string> sources;
    scene::CameraOptions camera;
    std::array<double, 2> resolution{1280, 720};
    double threshold_px = 1, budget_ms = 33;
    std::string splat = "smooth", shade = "lit", background = "0,0,0", backend = "auto", cache;
    std::array<double, 3> key_light{scene::kNotGiven, scene::kNotGiven, scene::kNotGiven};
    std::string record, screenshot;  // empty: not
    bool hide_status = false;
};

void add_options(core::Program& program, Arguments& arguments);

// Throws core::UsageError for what can be told without a window.
void check(const Arguments& arguments);

// These throw core::UsageError for words that they do not know.
render::Look look_of(const Arguments& arguments);
view::SubjectOptions subject_options(const Arguments& arguments);

}  // namespace qs_view
