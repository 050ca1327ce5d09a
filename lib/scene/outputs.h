// The files that drawing a path writes, by name.
#pragma once

#include <span>
#include <string>

#include "render/image.h"

namespace scene {

// Names as render::frame_name() takes them; empty: not written.
struct Outputs {
    std::string pictures, depths;
    render::ImageFormat format = render::ImageFormat::png;  // of the pictures
    std::string report;                                     // as it is
};

// The frames that are drawn: their numbers, and whether each is one of two eyes.
struct DrawnFrames {
    std::span<const int> numbers;
    bool is_stereo = false;
};

// Throws core::UsageError where a file would hold several pictures and cannot, be one of `inputs`, or be
// written twice.  Nothing is touched.  Some
// microseconds a file.
void check(const Outputs& outputs, std::span<const std::string> inputs, const DrawnFrames& frames);

}  // namespace scene
