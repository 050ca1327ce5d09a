#include "qs-render/picture_files.h"

#include "scene/shots.h"

namespace qs_render {

namespace {

bool holds_both(const std::string& name) {
    return !name.empty() && !render::has_eye(name);
}

}  // namespace

PictureFiles::PictureFiles(const std::string& pictures, render::ImageFormat format, double frames_per_s,
                           const std::string& depths)
    : pictures_(pictures),
      depths_(depths),
      is_beside_(holds_both(pictures) || holds_both(depths)),
      writer_(pictures, format, frames_per_s) {
    const auto is_to_come = [](const std::string& name) { return !name.empty() && name != "-"; };
    if (is_to_come(pictures) || is_to_come(depths)) to_come_.emplace();
}

void PictureFiles::write(int number, const std::string& eye, const render::Frame& frame) {
    const bool is_left = eye == "left";
    if (is_left && is_beside_) left_ = frame;
    if (!is_left && !eye.empty() && is_beside_) scene::put_side_by_side(left_, frame, both_);
    const render::Frame& last = eye.empty() ? frame : both_;  // of what has one picture a frame
    if (render::has_eye(pictures_))
        writer_.write(number, frame, eye);
    else if (!pictures_.empty() && !is_left)
        writer_.write(number, last);
    if (render::has_eye(depths_))
        writer_.write_depth(depths_, number, frame, eye);
    else if (!depths_.empty() && !is_left)
        writer_.write_depth(depths_, number, last);
}

}  // namespace qs_render
