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

// Throws core::UsageError where a file would hold several pictures and cannot, be one of `inputs`, or be
// written twice.  Nothing is touched.  Some microseconds a file.
void check(const Outputs& outputs, std::span<const std::string> inputs, size_t frame_count);

}  // namespace scene
