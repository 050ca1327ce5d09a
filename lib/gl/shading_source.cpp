#include "gl/shading_source.h"

#include "core/error.h"

namespace gl {
namespace {

constexpr const char* kShading = R"(
uniform vec3 light;  // ambient, head, key
uniform vec3 towards_key;

uint nearest_byte(float value) { return uint(clamp(value, 0.0, 255.0) + 0.5); }

// 0xffBBGGRR: the highest byte says that something was drawn.
uint packed_rgb(vec3 rgb) {
    return 0xff000000u | nearest_byte(rgb.b) << 16 | nearest_byte(rgb.g) << 8 | nearest_byte(rgb.r);
}

vec3 unpacked_rgb(uint c) { return vec3(c & 255u, c >> 8 & 255u, c >> 16 & 255u); }

uint shaded(vec3 normal, vec3 material) {
#if SHADE == NORMAL
    return packed_rgb(vec3(127.5 + 127.5 * normal.x, 127.5 - 127.5 * normal.y, 127.5 - 127.5 * normal.z));
#elif SHADE == FLAT
    return packed_rgb(material);
#else
    return packed_rgb(material * (light.x + light.y * max(-normal.z, 0.0) + light.z * max(dot(normal, towards_key), 0.0)));
#endif
}
)";

}  // namespace

std::string shading_source(render::Shade shade) {
    std::string text =
        "#version 330 core\n#define LIT 0\n#define NORMAL 1\n#define LEVEL 2\n#define FLAT 3\n";
    text += core::text("#define SHADE %d\n#define GREY %.9g\n", int(shade), double(render::kGreyMaterial));
    return text + kShading;
}

void set_light(const Use& gl, GLuint program, const render::Light& light) {
    gl->Uniform3f(gl->GetUniformLocation(program, "light"), light.ambient, light.head, light.key);
    const glm::vec3& l = light.towards_key;
    gl->Uniform3f(gl->GetUniformLocation(program, "towards_key"), l.x, l.y, l.z);
}

}  // namespace gl
