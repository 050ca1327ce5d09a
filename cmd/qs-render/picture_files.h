// The pictures and depths of a path on their way into files.
#pragma once

#include <optional>
#include <string>

#include "core/file.h"
#include "render/image.h"

namespace qs_render {

// Names as render::frame_name() takes them; empty: not written.  Where there are two eyes, a name with a
// place for the eye is a file for each, and any other holds both, the left one's picture on the left.
class PictureFiles {
  public:
    PictureFiles(const std::string& pictures, render::ImageFormat format, double frames_per_s,
                 const std::string& depths);

    // `eye`: empty, or "left" and then "right" for each frame.
    void write(int number, const std::string& eye, const render::Frame& frame);
    void finish() { writer_.finish(); }

  private:
    std::string pictures_, depths_;
    bool is_beside_;                              // two eyes go into one file
    std::optional<core::OutputsToCome> to_come_;  // each opened with its first frame
    render::FrameWriter writer_;
    render::Frame left_, both_;
};

}  // namespace qs_render
