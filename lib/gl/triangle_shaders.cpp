#include "gl/triangle_shaders.h"

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "gl/shading_source.h"

namespace gl {
namespace {

constexpr const char* kVertex = R"(
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal_in;
layout(location = 2) in vec3 material_in;

uniform vec2 principal;  // where the line of sight meets the part, in its pixels
uniform vec2 size;       // of the part
uniform float focal;
uniform float nearest;

out vec3 normal;
out vec3 material;

void main() {
    normal = normal_in;
    material = material_in;
    // Window coordinates of the part, times depth; the frame's y points down, as rows are read from 0.
    vec2 window = focal * place.xy + principal * place.z;
    gl_Position = vec4(2.0 * window / size - place.z, 2.0 * nearest - place.z, place.z);
}
)";

constexpr const char* kFragment = R"(
in vec3 normal;
in vec3 material;

layout(location = 0) out uvec2 result;
#if KEEPS_DEPTH
layout(location = 1) out float kept;
#endif

uniform vec2 limits;     // least and greatest inverse depth
uniform float nearest;
uniform mat3 normals_turned;

void main() {
    float w = gl_FragCoord.w;
    if (w < limits.x || w > limits.y) discard;
    gl_FragDepth = clamp(w * nearest, 1.0e-37, 1.0);
    float squares = dot(normal, normal);
    vec3 n = squares > 0.0 ? normals_turned * (normal / sqrt(squares)) : vec3(0);
    result = uvec2(floatBitsToUint(w), shaded(n, material));
#if KEEPS_DEPTH
    kept = w;
#endif
}
)";

}  // namespace

GLuint make_triangle_program(const Use& gl, const TriangleVariant& variant) {
    const std::string heading =
        shading_source(variant.shade) + core::text("#define KEEPS_DEPTH %d\n", int(variant.keeps_depth));
    return make_program(gl, heading + kVertex, heading + kFragment);
}

void set_uniforms(const Use& gl, GLuint program, const TriangleUniforms& uniforms) {
    const auto uniform = [&](const char* name) { return gl->GetUniformLocation(program, name); };
    const geom::View& view = uniforms.view;
    set_light(gl, program, uniforms.light);
    constexpr double kMost = std::numeric_limits<float>::max();
    const auto inverse = [&](double depth) { return float(std::min(1 / (depth * uniforms.unit), kMost)); };
    gl->Uniform2f(uniform("limits"), view.far ? inverse(*view.far) : 0,
                  view.near ? inverse(*view.near) : float(kMost));
    gl->Uniform1f(uniform("nearest"), float(uniforms.nearest));
    gl->UniformMatrix3fv(uniform("normals_turned"), 1, GL_FALSE, &uniforms.normals_turned[0][0]);
}

void set_part(const Use& gl, GLuint program, const geom::View& view, const Part& part, int steps) {
    const auto uniform = [&](const char* name) { return gl->GetUniformLocation(program, name); };
    const glm::vec2 principal((view.principal_in_raster() - glm::dvec2(part.x, part.y)) * double(steps));
    gl->Uniform2f(uniform("principal"), principal.x, principal.y);
    gl->Uniform2f(uniform("size"), float(part.width * steps), float(part.height * steps));
    gl->Uniform1f(uniform("focal"), float(view.focal_px) * float(steps));
}

}  // namespace gl
