// Which parts of the pipeline a frame needed, which were left out, and why.
#pragma once

#include <string>
#include <vector>

#include "core/json.h"
#include "scene/backends.h"
#include "scene/frame_report.h"

namespace scene {

struct Part {
    std::string name;
    bool is_used = false;
    std::string why;  // or how much of it
};

struct Explanation {
    std::vector<std::string> models;
    FrameReport frame;
    std::vector<Part> parts;
};

// OpenGL, which the back end uses or does not.
Part part_of(const Backend& backend);

// Draws the frame, so that what is said is what was done.
Explanation explain(ModelPainter& painter, const geom::View& view, const DrawOptions& options);

std::string to_text(const Explanation& explanation);  // lines, for people
// The keys of the frame's report but its times; and "parts".
core::Json to_json(const Explanation& explanation);

}  // namespace scene
