#include "gl/splat_shaders.h"

#include <cmath>

#include "core/error.h"
#include "gl/shading_source.h"
#include "render/shading.h"
#include "render/splat_record.h"

namespace gl {
namespace {

// render/splat_outline-inl.h in single precision; the formulas are explained there.
constexpr const char* kVertex = R"(
layout(location = 0) in vec4 place;   // centre in view space, radius
layout(location = 1) in vec4 facing;  // normal, flatness
layout(location = 2) in uint colour;

// All places are in pixels of the picture, so that those of a part are the whole's.
uniform vec2 principal;  // where the line of sight meets the picture
uniform vec2 origin;     // first pixel that is drawn
uniform vec2 size;       // and how many
uniform float focal;

flat out vec2 middle;   // of the outline, from the first pixel that is drawn
flat out vec4 form;     // l1, l2, l3, push
flat out vec2 core;     // core_a, core_b / kCoreScale
flat out vec3 depth;    // w, w_dx, w_dy
flat out vec3 normal;
flat out vec3 material; // 0..255
#if QUADS
flat out vec4 near_centre;  // of a splat that each pixel's ray is to meet: centre / radius; 1, or 0 for others
flat out vec2 near_shape;   // flatness squared, 1 / radius
#endif

struct Outline {
    vec2 shift, extent;
    vec3 form, depth;
    float clearance;
    vec2 core;
};

Outline aligned_outline(float inverse_z, float radius_px) {
    float edge = KIND == SQUARE ? 1.0 : 1.0 - 0.5 * EDGE;
    return Outline(vec2(0), vec2(radius_px), vec3(edge / radius_px, 0, edge / radius_px), vec3(inverse_z, 0, 0), 1.0,
                   vec2(0));
}

Outline ellipsoid_outline(vec2 t, float inverse_z, float r, float radius_px, vec3 n, float flatness) {
    float c = flatness * flatness, g = 1.0 - c, r2 = r * r;
    vec3 n2 = n * n;
    float szz = n2.x + n2.y + c * n2.z;
    float clearance = 1.0 - r2 * szz;
    vec2 e = r2 / clearance * (t * szz + g * n.xy * n.z);
    vec2 across = n.z + t * n.xy;     // a x n and b x n, but for their other components
    vec2 along = n.xy - t * n.z;      // a.n, b.n
    float asa = n2.y * (1.0 + t.x * t.x) + across.x * across.x + c * along.x * along.x;
    float bsb = n2.x * (1.0 + t.y * t.y) + across.y * across.y + c * along.y * along.y;
    float asb = t.x * n.y * across.y + t.y * n.x * across.x - n.x * n.y + c * along.x * along.y;
    float vxx = max(asa - r2 * (n2.y + c * (n2.x + n2.z)), 1.0e-30);
    float vyy = max(bsb - r2 * (n2.x + c * (n2.y + n2.z)), 1.0e-30);
    float vxy = asb + r2 * g * n.x * n.y;
    float np = dot(n, vec3(t, 1));
    float s = c * (dot(t, t) + 1.0) + g * np * np;
    float det = max(s - c * r2, 1.0e-30);

    Outline o;
    o.clearance = min(clearance, det / s);
    o.shift = e * focal;
    o.extent = radius_px / clearance * sqrt(vec2(vxx, vyy));
    const float edge = (1.0 - 0.5 * EDGE) * (1.0 - GROWTH);
    float k = sqrt(clearance / (vyy * det)) * (edge / radius_px);
    o.form = vec3(vyy * k, -vxy * k, edge / o.extent.y);
    vec2 thinned = radius_px / clearance * sqrt(c) * CORE_THINNED * along;
    vec2 m = vec2(o.form.x * thinned.x + o.form.y * thinned.y, o.form.z * thinned.y);
    m *= CORE_SCALE * inversesqrt(max(1.0 - dot(m, m), CORE_LEAST));
    o.core = trunc(clamp(m, -CORE_MOST, CORE_MOST)) / CORE_SCALE;
    vec2 u = (c * t + g * np * n.xy) / s;
    o.depth = inverse_z * vec3(1.0 + dot(e, u), u / focal);
    return o;
}

vec3 level_colour(float diameter_px) {
    const vec3 scale[9] = vec3[9](LEVEL_COLOURS);
    int i = 0;
    for (float limit = 1.0; i < 8 && diameter_px >= limit; limit *= 2.0) ++i;
    return scale[i];
}

vec3 material_of_splat() {
#if SHADE == LEVEL
    return level_colour(2.0 * focal * place.w / abs(place.z));
#elif HAS_COLOUR
    return unpacked_rgb(colour);
#else
    return vec3(GREY);
#endif
}

const vec4 kUnseen = vec4(2, 2, 0, 1);

// All pixels from `first` to `last`; kUnseen if there are none.
vec4 cover(vec2 first, vec2 last) {
    first -= origin, last -= origin;
    if (any(lessThan(last, first))) return kUnseen;
#if QUADS
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec2 at = mix(first, last + 1.0, corner);
#else
    vec2 pixels = last - first + 1.0;
    gl_PointSize = max(pixels.x, pixels.y);
    vec2 at = 0.5 * (first + last + 1.0);
#endif
    return vec4(2.0 * at / size - 1.0, 0, 1);
}

// How far `coordinate` is beyond the side where focal * coordinate = place * z.
vec2 beyond(vec2 coordinate, vec2 place, float z) {
    return (coordinate * focal - place * z) / sqrt(focal * focal + place * place);
}

bool may_be_seen(vec3 p, float radius) {
    vec2 middle = principal - origin;
    return all(lessThanEqual(max(beyond(-p.xy, middle, p.z), beyond(p.xy, size - middle, p.z)), vec2(radius)));
}

void main() {
    float inverse_z = 1.0 / place.z;
    vec2 t = place.xy * inverse_z;
    float r = place.w * inverse_z;
    float radius_px = clamp(r * focal, 1.0e-5, 1.0e15);
    float flatness = max(facing.w, MIN_FLATNESS);
    bool is_aligned = KIND == SQUARE || KIND == CIRCLE;
    Outline o = is_aligned ? aligned_outline(inverse_z, radius_px)
                           : ellipsoid_outline(t, inverse_z, r, radius_px, facing.xyz, flatness);
    vec2 centre = t * focal + principal + o.shift;
    float ray_length = sqrt(1.0 + dot(t, t)), along_ray = r / ray_length;
    float push = is_aligned ? 0.0 : inverse_z * (along_ray / (1.0 + along_ray));
#if IS_BLENDED
    float along_normal = max(abs(dot(facing.xyz, vec3(t, 1))), 1.0e-6);
    push *= min(1.0, (REACH + REACH_BY_FLATNESS * flatness) * ray_length / along_normal);
#endif
    middle = centre - origin;
    form = vec4(o.form, push);
    depth = o.depth;
    core = o.core;
    normal = facing.xyz;
    material = material_of_splat();

    // What float can be off by at that place, and more.
    vec2 end = origin + size - 1.0;
    vec2 reach = o.extent * 1.0001 + 1.0e-4 + end * 3.0e-7;
    vec2 low = centre - 0.5 - reach, high = centre - 0.5 + reach;
    bool is_before_eye = place.z > 0.0;
    bool on_screen = all(lessThanEqual(low, end)) && all(greaterThanEqual(high, origin));  // false for NaN
    vec2 first = ceil(max(low, origin)), last = floor(min(high, end));
    gl_PointSize = 1.0;
#if QUADS
    near_centre = vec4(0), near_shape = vec2(0);
    if (!is_aligned && !(is_before_eye && o.clearance > MIN_CLEARANCE)) {
        bool is_behind = o.clearance >= 0.0 && !is_before_eye;
        bool is_bounded = is_before_eye && o.clearance > MIN_BOUNDED_CLEARANCE;
        gl_Position = kUnseen;
        if (is_behind || (is_bounded && !on_screen) || !may_be_seen(place.xyz, place.w)) return;
        near_centre = vec4(place.xyz / place.w, 1);
        near_shape = vec2(flatness * flatness, 1.0 / place.w);
        gl_Position = is_bounded ? cover(first, last) : cover(origin, end);
        return;
    }
#endif
    gl_Position = is_before_eye && on_screen ? cover(first, last) : kUnseen;
}
)";

// render/tile_pixels-inl.h, for a pixel: what a splat puts into it.
constexpr const char* kFragment = R"(
flat in vec2 middle;
flat in vec4 form;
flat in vec3 depth;
flat in vec2 core;
flat in vec3 normal;
flat in vec3 material;
#if QUADS
flat in vec4 near_centre;
flat in vec2 near_shape;
#endif

uniform vec2 principal;
uniform vec2 origin;
uniform float focal;
uniform vec2 limits;       // least and greatest inverse depth
uniform float depth_scale; // from inverse depths to GL's
#if HAS_TRIANGLES
uniform sampler2D triangles;  // their inverse depths
uniform float triangle_lead;  // by which they are multiplied against those of splats
#endif

struct Fragment {
    float w, t, push;
    float gain;   // gain_of()
    float order;  // 1, or for covers what makes them farther than any core
};

#if QUADS
Fragment near_fragment() {
    vec3 p = near_centre.xyz, n = normal;
    float c = near_shape.x, g = 1.0 - c;
    float np = dot(n, p);
    vec3 u = c * p + g * np * n;
    float pup = c * dot(p, p) + g * np * np;
    vec3 d = vec3((gl_FragCoord.xy + origin - principal) / focal, 1);
    vec3 m = cross(d, p), k = cross(n, m);
    float nd = dot(n, d), du = dot(d, u);
    float dad = c * dot(d, d) + g * nd * nd;
    float chord = dad * 1.00002 - (c * dot(m, m) + g * dot(k, k));
    float w;
    if (pup <= c) {  // the eye is inside
        w = dad / max(du + sqrt(max(c * chord, 0.0)), 1.0e-30);
    } else {
        if (!(chord >= 0.0 && du > 0.0)) discard;
        w = du / pup;
    }
    w = min(w, 1.0e6);
    return Fragment(w * near_shape.y, EDGE, w * near_shape.y * (w / (1.0 + w)), 1.0, 1.0);
}
#endif

Fragment outline_fragment() {
    vec2 d = gl_FragCoord.xy - middle;
    float a = form.x * d.x + form.y * d.y, b = form.z * d.y;
    Fragment f;
    f.push = form.w;
    f.gain = form.w * MOST_GAIN > depth.x ? depth.x / form.w : MOST_GAIN;
    f.w = depth.x + (depth.y * d.x + depth.z * d.y);
#if KIND == SQUARE
    f.t = 1.0;
    if (!(max(abs(a), abs(b)) <= 1.0)) discard;
#else
    f.t = 1.0 - b * b - a * a;
    if (!(f.t >= EDGE)) discard;
#endif
    f.order = 1.0;
#if HAS_CORES
    float s = core.x * a + core.y * b;
    if (!(f.t - s * s >= CORE_EDGE)) f.order = COVER_ORDER;
#endif
    return f;
}

Fragment splat_fragment() {
#if QUADS
    Fragment f;
    if (near_centre.w > 0.0) f = near_fragment(); else f = outline_fragment();
#else
    Fragment f = outline_fragment();
#endif
#if HAS_LIMITS
    if (!(f.w >= limits.x && f.w <= limits.y)) discard;
#endif
#if HAS_TRIANGLES
    if (!(f.w > texelFetch(triangles, ivec2(gl_FragCoord.xy), 0).r * triangle_lead)) discard;
#endif
    return f;
}

// Above 0, which is what nothing was drawn on, and above what is flushed to it.
float buffer_depth(Fragment f, float key) { return clamp(key * depth_scale, LEAST_DEPTH, 1.0) * f.order; }
)";

constexpr const char* kNearestPass = R"(
layout(location = 0) out uvec2 result;

void main() {
    Fragment f = splat_fragment();
    gl_FragDepth = buffer_depth(f, f.w - f.push * (1.0 - f.t));
    result = uvec2(floatBitsToUint(f.w), shaded(normal, material));
}
)";

constexpr const char* kFrontPass = R"(
void main() {
    Fragment f = splat_fragment();
    gl_FragDepth = buffer_depth(f, f.w);
}
)";

constexpr const char* kWithinFront = R"(
uniform sampler2D front;

// A splat of no size in a float's eyes is still within its own R of itself.
const float kRounding = 5.0e-7;

Fragment fragment_within_front() {
    Fragment f = splat_fragment();
    float nearest = texelFetch(front, ivec2(gl_FragCoord.xy), 0).r;
    if (buffer_depth(f, f.w) < nearest - f.push * f.order * depth_scale - nearest * kRounding) discard;
    return f;
}
)";

constexpr const char* kSumPass = R"(
layout(location = 0) out vec4 normals;
#if HAS_MATERIAL
layout(location = 1) out vec4 colours;
#endif

void main() {
    Fragment f = fragment_within_front();
    float weight = f.t * f.gain;
    normals = weight * vec4(normal, 1);
#if HAS_MATERIAL
    colours = weight * vec4(material, 1);
#endif
}
)";

constexpr const char* kLeadPass = R"(
layout(location = 0) out float lead;

void main() {
    Fragment f = fragment_within_front();
    gl_FragDepth = f.t * f.gain / MOST_GAIN;
    lead = f.w;
}
)";

constexpr const char* kResolve = R"(
layout(location = 0) out uvec2 result;

uniform sampler2D normals;
uniform sampler2D colours;
uniform sampler2D lead;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(normals, at, 0);
    if (!(sum.w > 0.0)) discard;
    // Opposite normals may cancel to nothing; the pixel is then left with ambient light.
    vec3 normal = sum.xyz / sqrt(max(dot(sum.xyz, sum.xyz), 1.0e-30));
#if HAS_MATERIAL
    vec3 material = texelFetch(colours, at, 0).rgb / sum.w;
#else
    vec3 material = vec3(GREY);
#endif
    result = uvec2(floatBitsToUint(texelFetch(lead, at, 0).r), shaded(normal, material));
}
)";

std::string level_colours() {
    std::string list;
    for (int i = 0; i < 9; ++i) {
        const glm::u8vec3 c = render::level_colour(i == 0 ? 0.5f : float(1 << (i - 1)));
        list += core::text("%svec3(%d, %d, %d)", i == 0 ? "" : ", ", c.r, c.g, c.b);
    }
    return list;
}

std::string heading(const SplatVariant& v) {
    std::string text = shading_source(v.shade) + "#define SQUARE 0\n#define CIRCLE 1\n";
    text += core::text("#define KIND %d\n#define HAS_COLOUR %d\n#define HAS_LIMITS %d\n#define QUADS %d\n",
                       int(v.kind), int(v.has_colour), int(v.has_limits), int(v.quads));
    text += core::text("#define HAS_MATERIAL %d\n#define HAS_TRIANGLES %d\n", int(v.has_material()),
                       int(v.has_triangles));
    text += core::text("#define EDGE %.9g\n#define GROWTH %.9g\n#define MIN_FLATNESS %.9g\n",
                       double(render::kEdge), double(render::kGrowth), double(render::kMinFlatness));
    text += core::text("#define MOST_GAIN %.9g\n#define IS_BLENDED %d\n", double(render::kMostGain),
                       int(v.kind == render::SplatKind::smooth));
    text += core::text("#define REACH %.9g\n#define REACH_BY_FLATNESS %.9g\n", double(render::kReach),
                       double(render::kReachByFlatness));
    const bool has_cores = v.kind == render::SplatKind::ellipse || v.kind == render::SplatKind::smooth;
    const double flatness = double(render::kCoreFlatness);
    text += core::text("#define HAS_CORES %d\n#define CORE_EDGE %.9g\n#define CORE_THINNED %.9g\n",
                       int(has_cores), double(render::kCoreEdge), std::sqrt(1 - flatness * flatness));
    text += core::text("#define CORE_LEAST %.9g\n#define CORE_SCALE %.9g\n#define CORE_MOST 32767.0\n",
                       flatness * flatness, double(render::kCoreScale));
    // Two ranges, one above the other, in what a float has from 2^-126 to 1.
    text += core::text("#define COVER_ORDER %.9g\n#define LEAST_DEPTH %.9g\n", double(render::kCoverOrder),
                       0x1p-90);
    text += core::text("#define MIN_CLEARANCE %.9g\n#define MIN_BOUNDED_CLEARANCE %.9g\n",
                       double(render::kMinClearance), double(render::kMinBoundedClearance));
    return text + "#define LEVEL_COLOURS " + level_colours() + "\n";
}

}  // namespace

std::string splat_vertex_source(const SplatVariant& variant) {
    return heading(variant) + kVertex;
}

std::string splat_fragment_source(const SplatVariant& variant) {
    const std::string start = heading(variant) + kFragment;
    switch (variant.pass) {
        case SplatPass::nearest:
            return start + kNearestPass;
        case SplatPass::front:
            return start + kFrontPass;
        case SplatPass::sum:
            return start + kWithinFront + kSumPass;
        case SplatPass::lead:
            return start + kWithinFront + kLeadPass;
    }
    return start;
}

std::string screen_vertex_source() {
    return R"(#version 330 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";
}

std::string resolve_source(const SplatVariant& variant) {
    return heading(variant) + kResolve;
}

}  // namespace gl
