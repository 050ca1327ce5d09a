// The shaders that draw triangles as render::MeshRaster does.
#pragma once

#include <string>

#include "gl/objects.h"
#include "render/backend.h"
#include "render/shading.h"

namespace gl {

struct TriangleVariant {
    render::Shade shade;
    bool keeps_depth;  // the inverse depth once more, as a float of its own
    auto operator<=>(const TriangleVariant&) const = default;
};

// Attributes: 0, place in view space; 1, normal; 2, material, 0..255.  Into kUints2, and kFloat where depth
// is kept.
GLuint make_triangle_program(const Use& gl, const TriangleVariant& variant);

// What a frame's triangles have in common; lengths in the unit of their places.
struct TriangleUniforms {
    const geom::View& view;
    double unit;     // by which lengths of the view are multiplied
    double nearest;  // nothing nearer to the eye is drawn, which is above 0
    render::Light light;
    glm::mat3 normals_turned{1};  // from their space to view space
};
void set_uniforms(const Use& gl, GLuint program, const TriangleUniforms& uniforms);

// Those of a part of the frame, which is drawn with steps x steps pixels for each.
void set_part(const Use& gl, GLuint program, const geom::View& view, const Part& part, int steps);

}  // namespace gl
