// The shaders that draw splats as render::Splatter does.
#pragma once

#include <string>

#include "render/backend.h"

namespace gl {

// What a pass over the splats writes.
enum class SplatPass {
    nearest,  // the splat in front, pushed back by its hill: its colour and inverse depth
    front,    // the greatest inverse depth, as depth
    sum,      // weighted normals and colours of what is within its push of the front
    lead      // of that, the inverse depth of the splat of largest weight
};

// All that the text of the shaders depends on.
struct SplatVariant {
    SplatPass pass;
    render::SplatKind kind;
    render::Shade shade;
    bool has_colour;
    bool has_limits;     // near or far
    bool has_triangles;  // which splats may be behind
    bool quads;          // rectangles, for splats that are large or near the eye, instead of points
    // What is summed has colours of its own to be shaded with.
    bool has_material() const {
        return (has_colour || shade == render::Shade::level) && shade != render::Shade::normal;
    }
    auto operator<=>(const SplatVariant&) const = default;
};

std::string splat_vertex_source(const SplatVariant& variant);
std::string splat_fragment_source(const SplatVariant& variant);

// One triangle over all of the picture, which shades what SplatPass::sum and lead wrote.
std::string screen_vertex_source();
std::string resolve_source(const SplatVariant& variant);

}  // namespace gl
