// A shape taken through the whole chain (PLY, mesh, model), and what can be measured of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "geom/camera.h"
#include "mesh/mesh.h"
#include "render/compare.h"
#include "render/frame.h"
#include "scene/draw.h"
#include "shapes.h"
#include "splat/build.h"
#include "splat/model.h"

namespace stability {

struct Subject {
    Shape shape;
    mesh::Mesh mesh;  // as read
    mesh::ReadCounts counts;
    splat::BuildReport report;
    std::string bytes;  // of the model, as qs-build writes them
    std::unique_ptr<splat::Model> model;

    double radius() const { return model->header().scale; }
};

// Throws core::Error as reader and builder do.
Subject build(const Shape& shape, Precision precision, const mesh::ReadOptions& options = {},
              splat::Leaf leaf = splat::Leaf::point);

// A file that holds `bytes` and is deleted already.
core::InputFile nameless_file(const std::string& bytes);

// How far the worst finite vertex of a triangle (of a cloud: the worst vertex) is outside of all leaves'
// ellipsoids as decoded, in parts of the model's radius.  Up to 4e7 pairs of vertex and leaf take a second.
double worst_uncovered_vertex(const Subject& subject);

struct Picture {
    geom::View view;
    render::Frame frame;
    scene::DrawReport report;
};

scene::DrawOptions all_detail();
Picture draw(const Subject& subject, const geom::Camera& camera, const scene::DrawOptions& options);

// A camera that sees the whole model, a little from above.
geom::Camera fitted_camera(const Subject& subject);

// Pixels whose depth is neither a positive finite number nor infinity.
uint64_t bad_pixels(const render::Frame& frame);
uint64_t covered_pixels(const render::Frame& frame);

// Against the mesh, drawn exactly.  Not for clouds.
render::ImageDifference difference_from_mesh(const Subject& subject, const Picture& picture);

// The largest distance of a shown point from the mesh, as projected: what error_bound_px bounds.
double measured_error_px(const Subject& subject, const Picture& picture);

// Rounding of world coordinates in measured_error_px itself.
double measurement_rounding_px(const Picture& picture);

}  // namespace stability
