// Views for the tests of drawing, and what is drawn of them.
#pragma once

#include <vector>

#include "geom/camera.h"
#include "geom/sphere.h"
#include "mesh/mesh.h"
#include "scene/draw.h"
#include "splat/model.h"

namespace scene_test {

// The whole of the model, from the front.
geom::View fitted_view(const splat::Model& model, int width = 160, int height = 120);

// From outside of the model's bounds, near and far, in random directions, at random points of the surface,
// with fields of view from 60 degrees down to a thousandth of what shows the whole model.
std::vector<geom::View> random_views(const splat::Model& model, const mesh::Mesh& mesh, int count);

// From just before random points of the surface, along their normals, at 1e-3 to 0.3 radii of the model.
std::vector<geom::View> close_views(const splat::Model& model, const mesh::Mesh& mesh, int count);

struct Drawn {
    render::Frame frame;
    scene::DrawReport report;
};

Drawn draw(const std::vector<scene::PlacedModel>& models, const geom::View& view,
           const scene::DrawOptions& options = {});

// The same picture, and the same work for it.
void expect_same(const Drawn& a, const Drawn& b);

}  // namespace scene_test
