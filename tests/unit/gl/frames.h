// Contexts of OpenGL for the tests, and how far two frames are from each other.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "gl/device.h"
#include "render/frame.h"

namespace gl_test {

// "osmesa", "egl" (by device) or "surfaceless".
inline const char* const kContexts[] = {"osmesa", "egl", "surfaceless"};
// Where there is no graphics processor, the last two draw with the same driver.
inline const char* const kDrawingContexts[] = {"osmesa", "egl"};

// Null, and the reason, where the machine has not the library of that name, or its EGL does not know the
// platform. Throws core::Error where the library is there and does not work: that is no reason to skip a
// test.
std::unique_ptr<gl::Device> open(const std::string& context, std::string& reason);

struct Difference {
    double psnr_db;        // infinity where equal
    double turned;         // share of all pixels with a channel that differs by more than a level
    double covered_apart;  // share of all pixels that one of them covers alone
    double depth;          // largest relative difference of depths but for a thousandth of the pixels
};
Difference difference(const render::Frame& a, const render::Frame& b);
std::ostream& operator<<(std::ostream& out, const Difference& d);

}  // namespace gl_test
