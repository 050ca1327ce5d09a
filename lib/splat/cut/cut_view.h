// A view as the cut of one model sees it: in model space, with the limits on what is drawn.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "geom/camera.h"
#include "splat/cut.h"

namespace splat {

// In a block whose middle triangle is this much shorter than a leaf must be wide to be drawn as a triangle,
// most leaves are too small: circles are wider than sides, and nodes than circles.  A leaf that is so many
// times as wide as it must be is drawn as a triangle all the same.  (With 0.8 and 2 the whole dragon took a
// fifth longer, to read a few triangles each of many blocks, for the same PSNR; seen at 1.7 times the focal
// length a tenth, for 1.5 dB.)
constexpr float kSideOfDiameter = 0.9f, kTrianglesAlone = 3;

// The view in model space.  Positions are relative to `pivot`, a point on the line of sight at depth
// `pivot_depth`, so that what is near in depth is small in float.
struct Sides {
    glm::vec3 plane[4];     // unit normals, inwards
    float plane_offset[4];  // distance of the pivot from them
};
struct CutView {
    glm::dvec3 pivot{0};
    float pivot_depth = 0;
    float focal = 1;
    float unit = 1;  // of the splats that are handed out
    glm::vec3 right{0}, down{0}, forward{0};
    Sides sides;  // of the picture for the top, of the raster below it
    Sides raster_sides;
    float corner_cosine = 1;   // of the angle between the line of sight and a corner of the picture
    float near = 0, far = 0;   // depths between which something is drawn
    float limit_error = 0;     // threshold on e f / z
    float limit_diameter = 0;  // threshold on 2 R f / z
    float beyond_px() const { return by_error ? limit_error : 0; }  // see LargestErrors
    CutPlan plan;
    float limit_triangle = 0;    // on 2 R f / z of leaves
    float rounding = 0;          // of corners, model units
    double lattice_step = 1;     // of corners, model units
    bool has_triangles = false;  // some leaves may be handed out as such
    bool by_error = true, cull_backfaces = true, two_sided = false, has_colour = false;
    bool is_profiled = false;  // nothing is drawn: all that is visible is listed as open, with what it needs
    std::atomic<uint32_t>* last_number =
        nullptr;          // of waiting nodes, if they are listed; colours are then lanes
    uint32_t colour = 0;  // of all, where there is no channel

    glm::vec3 turned(const glm::vec3& n) const {
        return {glm::dot(right, n), glm::dot(down, n), glm::dot(forward, n)};
    }
    // From what is relative to the pivot, in the splats' unit.
    glm::vec3 in_view(const glm::vec3& at) const {
        return unit * glm::vec3(glm::dot(right, at), glm::dot(down, at), glm::dot(forward, at) + pivot_depth);
    }
};

CutView make_cut_view(const Model& model, const geom::View& view, const CutOptions& options);

}  // namespace splat
