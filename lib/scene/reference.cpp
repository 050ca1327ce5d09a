#include "scene/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace scene {

namespace {

mesh::Mesh checked(mesh::Mesh mesh, const std::string& name, bool with_colour) {
    if (mesh.triangles.empty())
        throw core::Error(name + ": has no triangles; a reference must be a mesh with faces");
    if (!with_colour) mesh.colours = {};
    return mesh;
}

}  // namespace

Reference::Reference(mesh::Mesh mesh, const std::string& name, bool with_colour)
    : mesh_(checked(std::move(mesh), name, with_colour)), distance_(mesh_), raster_(mesh_) {}

ReferenceMeasures Reference::measure(const geom::View& view, const render::Look& look,
                                     const render::Frame& frame) {
    raster_.draw(view, look, frame_);
    return {render::compare(frame, frame_, view.focal_px), measured_error_px(distance_, view, frame)};
}

double measured_error_px(const mesh::SurfaceDistance& surface, const geom::View& view,
                         const render::Frame& frame) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::vector<double> largest(size_t(frame.height), 0.0);  // by row
    core::parallel_for(size_t(frame.height), [&](size_t y) {
        for (int x = 0; x < frame.width; ++x) {
            const double depth = double(frame.depth[y * size_t(frame.width) + size_t(x)]);
            if (!std::isfinite(depth)) continue;
            const glm::dvec3 point = point_of_pixel(view, frame, x, int(y));
            const double error_px = surface.distance(point, kInfinity) * view.focal_px / depth;
            // Written so that a NaN counts: an error that cannot be told is not a small one.
            if (!(error_px <= largest[y])) largest[y] = std::isnan(error_px) ? kInfinity : error_px;
        }
    });
    return *std::max_element(largest.begin(), largest.end());
}

double rounding_px(const geom::View& view) {
    return 2e-3 + 1e-6 * view.height + std::ldexp(view.focal_px, -22);
}

glm::dvec3 point_of_pixel(const geom::View& view, const render::Frame& frame, int x, int y) {
    const double depth = double(frame.depth[size_t(y) * size_t(frame.width) + size_t(x)]);
    const glm::dvec2 principal = view.principal_in_raster();
    const double right = (x + frame.depth_at - principal.x) / view.focal_px;
    const double down = (y + frame.depth_at - principal.y) / view.focal_px;
    return view.eye + depth * (view.forward + right * view.right + down * view.down);
}

}  // namespace scene
