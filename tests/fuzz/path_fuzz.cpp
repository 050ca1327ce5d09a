// Any bytes: a path whose cameras all make a view and read back from their text bit for bit, and
// through which a spline is a path or an Error; or Error.  Nothing else.
#include <cstdint>
#include <string_view>

#include "core/error.h"
#include "geom/path.h"
#include "require.h"

namespace {

void check_views(const std::vector<geom::Camera>& path) {
    for (const geom::Camera& camera : path) {
        const geom::View view = geom::make_view(camera, 1280, 720);
        for (const glm::dvec3& axis : {view.right, view.down, view.forward})
            require(glm::abs(glm::length(axis) - 1) < 1e-15, "axes are of unit length");
        require(view.focal_px > 0 && view.focal_px < 1e15, "the focal length is in range");
    }
}

void check_spline(const std::vector<geom::Camera>& keys) {
    try {
        check_views(geom::spline(keys, {.frames = 16}));
    } catch (const core::Error&) {
        // too few keys, or the eye meets its target
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    try {
        const auto path = geom::parse_path({reinterpret_cast<const char*>(data), size}, "fuzz");
        check_views(path);
        const std::string text = geom::format_path(path);
        require(geom::format_path(geom::parse_path(text, "again")) == text, "a path reads back bit for bit");
        check_spline(path);
    } catch (const core::Error&) {
        // rejecting is fine
    }
    return 0;
}
