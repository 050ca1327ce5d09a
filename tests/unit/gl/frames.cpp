#include "frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "gl/library.h"

namespace gl_test {

std::unique_ptr<gl::Device> open(const std::string& context, std::string& reason) {
    const bool is_osmesa = context == "osmesa";
    try {
        const gl::Library library(is_osmesa ? "libOSMesa.so.8" : "libEGL.so.1", "its package");
    } catch (const core::Error& error) {
        reason = error.what();
        return nullptr;
    }
    // What is installed is to work, but that not every EGL knows Mesa's platform.
    if (is_osmesa) return std::make_unique<gl::Device>(gl::make_osmesa_context());
    if (context == "egl") return std::make_unique<gl::Device>(gl::make_egl_context(gl::EglPlatform::device));
    try {
        return std::make_unique<gl::Device>(gl::make_egl_context(gl::EglPlatform::surfaceless));
    } catch (const core::Error& error) {
        reason = error.what();
        return nullptr;
    }
}

Difference difference(const render::Frame& a, const render::Frame& b) {
    EXPECT_EQ(a.rgb.size(), b.rgb.size());
    EXPECT_EQ(a.depth.size(), b.depth.size());
    double squares = 0;
    size_t turned = 0, apart = 0;
    std::vector<double> depths(b.depth.size(), 0.0);
    for (size_t i = 0; i < b.depth.size(); ++i) {
        int most = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
            const int d = std::abs(int(a.rgb[c]) - int(b.rgb[c]));
            most = std::max(most, d);
            squares += d * d;
        }
        turned += most > 1;
        const bool in_a = std::isfinite(a.depth[i]), in_b = std::isfinite(b.depth[i]);
        apart += in_a != in_b;
        if (in_a && in_b) depths[i] = std::abs(double(a.depth[i]) / double(b.depth[i]) - 1);
    }
    const auto pixels = double(b.depth.size());
    const auto most = depths.begin() + std::ptrdiff_t(0.999 * (pixels - 1));
    std::nth_element(depths.begin(), most, depths.end());
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return {squares > 0 ? 10 * std::log10(255.0 * 255.0 * 3 * pixels / squares) : kInfinity,
            double(turned) / pixels, double(apart) / pixels, *most};
}

std::ostream& operator<<(std::ostream& out, const Difference& d) {
    return out << d.psnr_db << " dB, " << d.turned << " of the pixels turned, " << d.covered_apart
               << " covered by one alone, depths within " << d.depth;
}

}  // namespace gl_test
