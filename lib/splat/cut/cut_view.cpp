#include "splat/cut/cut_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace splat {

namespace {

// The sides of the pyramid through the raster, for a pivot at `depth`.
Sides sides_of(const geom::View& view, double depth) {
    const glm::dvec2 principal = view.principal_in_raster();
    const double left = principal.x / view.focal_px, right = (view.width - principal.x) / view.focal_px;
    const double above = principal.y / view.focal_px, below = (view.height - principal.y) / view.focal_px;
    const glm::dvec3 normals[4] = {view.right + left * view.forward, right * view.forward - view.right,
                                   view.down + above * view.forward, below * view.forward - view.down};
    Sides sides;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 n = glm::normalize(normals[k]);
        sides.plane[k] = glm::vec3(n);
        sides.plane_offset[k] = float(depth * glm::dot(n, view.forward));
    }
    return sides;
}

CutPlan make_plan(const Header& h, const CutOptions& options, bool is_cut_open) {
    CutPlan plan;
    if (!options.cull_backfaces)
        plan.backfaces = BackfaceTest::not_wanted;
    else if (h.flags & kOpenSurface)
        plan.backfaces = BackfaceTest::open_surface;
    else if (is_cut_open)
        plan.backfaces = BackfaceTest::cut_open_by_near;
    if (h.has_colour())
        plan.colour = ColourFrom::channel;
    else if (h.flags & kConstantColour)
        plan.colour = ColourFrom::header;
    return plan;
}

}  // namespace

CutView make_cut_view(const Model& model, const geom::View& view, const CutOptions& options) {
    const Header& h = model.header();
    CutView v;
    const glm::dvec3 eye = (view.eye - h.origin) / h.scale;
    // The depth of the model's middle, as far as the eye is outside.
    const double depth = std::max(0.0, -glm::dot(eye, view.forward) - 1.0);
    v.pivot = eye + depth * view.forward;
    v.pivot_depth = float(depth);
    v.focal = float(view.focal_px);
    v.right = glm::vec3(view.right), v.down = glm::vec3(view.down), v.forward = glm::vec3(view.forward);
    v.sides = sides_of(part_of(view, 0, 0, view.picture_width(), view.picture_height()), depth);
    v.raster_sides = sides_of(view, depth);
    const glm::dvec2 principal = view.principal();
    const double far_x = std::max(principal.x, view.picture_width() - principal.x) / view.focal_px;
    const double far_y = std::max(principal.y, view.picture_height() - principal.y) / view.focal_px;
    v.corner_cosine = float(1 / std::sqrt(1 + far_x * far_x + far_y * far_y));
    constexpr double kFarthest = std::numeric_limits<float>::max();
    v.near = float(std::min(view.near.value_or(0) / h.scale, kFarthest));
    v.far = float(std::min(view.far.value_or(kFarthest) / h.scale, kFarthest));
    v.by_error = options.by == CutBy::error;
    v.limit_error = float(options.threshold_px);
    v.limit_diameter =
        float(v.by_error ? options.threshold_px * double(kDiameterOfError) : options.threshold_px);
    v.has_triangles = h.has_triangles() && hands_out_triangles(options);
    v.limit_triangle = float(options.triangle_px);
    // sqrt(3) / 2 steps of the lattice, and what single precision makes of places up to 2 off the pivot.
    v.rounding = float(std::ldexp(0.87, -int(h.lattice_bits)) + 0x1p-21);
    v.lattice_step = std::ldexp(1.0, -int(h.lattice_bits));
    // What near cuts open shows its inside.
    const bool is_cut_open = view.near && *view.near / h.scale > -glm::dot(eye, view.forward) - 1.0;
    v.plan = make_plan(h, options, is_cut_open);
    v.cull_backfaces = v.plan.backfaces == BackfaceTest::made;
    v.last_number = options.last_number;
    v.two_sided = h.flags & kCloud;
    v.has_colour = v.plan.colour == ColourFrom::channel;
    v.colour = v.plan.colour == ColourFrom::header
                   ? uint32_t(h.colour[0]) | uint32_t(h.colour[1]) << 8 | uint32_t(h.colour[2]) << 16
                   : 0x00e6e6e6;
    return v;
}

}  // namespace splat
