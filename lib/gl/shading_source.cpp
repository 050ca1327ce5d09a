#include "gl/shading_source.h"

#include "core/error.h"
#include "render/shading.h"

namespace gl {
namespace {

constexpr const char* kShading = R"(
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
    return packed_rgb(material * (AMBIENT + DIFFUSE * max(-normal.z, 0.0)));
#endif
}
)";

}  // namespace

std::string shading_source(render::Shade shade) {
    std::string text =
        "#version 330 core\n#define LIT 0\n#define NORMAL 1\n#define LEVEL 2\n#define FLAT 3\n";
    text += core::text("#define SHADE %d\n#define AMBIENT %.9g\n#define DIFFUSE %.9g\n#define GREY %.9g\n",
                       int(shade), double(render::kAmbient), double(render::kDiffuse),
                       double(render::kGreyMaterial));
    return text + kShading;
}

}  // namespace gl
