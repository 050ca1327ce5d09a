// How a surface point becomes three bytes: one formula for every renderer, so that splats and
// triangles differ by geometry alone.  See Shade in frame.h for what the modes mean.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "geom/camera.h"
#include "render/frame.h"

namespace render {

// What a surface without colour is made of: 0.9 grey, as a (linear) byte value.
inline constexpr float kGreyMaterial = 255.0f * 0.9f;

// What falls on a surface: a factor of its material is
//     ambient + head * max(0, n.eye) + key * max(0, n.towards_key).
// By default all light is the head light's.  A key light takes most of it; the head light is then left to
// fill the shadows, so that no side is flat: what the key light does not reach still shows its form.
struct Light {
    float ambient = 0.05f, head = 0.95f, key = 0;
    glm::vec3 towards_key{0};  // unit, view space
};

inline Light light_of(const Look& look, const geom::View& view) {
    if (!look.key_light) return {};
    const glm::dvec3 v = glm::normalize(*look.key_light);
    return {0.05f, 0.35f, 0.6f, {glm::dot(view.right, v), glm::dot(view.down, v), glm::dot(view.forward, v)}};
}

// Nearest byte of a value in 0..255; values a rounding error outside are clamped, NaN is 0.
inline uint8_t nearest_byte(float value) {
    const float v = value > 0.0f ? value : 0.0f;
    // As nearest_bytes() of shading-inl.h does it for vectors, to the bit: what lies a rounding error below
    // a half goes up.  NOLINTNEXTLINE(bugprone-incorrect-roundings)
    return static_cast<uint8_t>(static_cast<int>((v < 255.0f ? v : 255.0f) + 0.5f));
}

// The light's factor for a view-space unit normal.
inline float factor_of(const Light& light, const glm::vec3& n) {
    const float towards_eye = n.z < 0.0f ? -n.z : 0.0f;
    const float factor = light.ambient + light.head * towards_eye;
    const glm::vec3& l = light.towards_key;
    const float towards_key = (n.x * l.x + n.y * l.y) + n.z * l.z;
    return factor + light.key * (towards_key > 0.0f ? towards_key : 0.0f);
}

// Colour of what is drawn `diameter_px` wide on screen, linear bytes; the scale of Shade::level:
// a colour for each power of two from below 1 px (dark blue) over 2..4 px (green) and 8..16 px
// (yellow) to 128 px and more (white).
inline glm::u8vec3 level_colour(float diameter_px) {
    static constexpr uint8_t kScale[9][3] = {
        {60, 60, 160},   // below 1 px
        {60, 140, 230},  // 1 to 2
        {60, 190, 90},   // 2 to 4
        {150, 210, 60},  // 4 to 8
        {240, 220, 60},  // 8 to 16
        {240, 150, 40},  // 16 to 32
        {220, 60, 50},   // 32 to 64
        {200, 80, 200},  // 64 to 128
        {255, 255, 255}  // 128 and more
    };
    int step = 0;
    for (float limit = 1.0f; step < 8 && diameter_px >= limit; limit *= 2.0f) ++step;
    return {kScale[step][0], kScale[step][1], kScale[step][2]};
}

// `normal`: unit, view space.  `material`: linear, 0..255 a channel; glm::vec3(kGreyMaterial) for a
// surface without colour, level_colour() for Shade::level; not used by Shade::normal.
inline glm::u8vec3 shade_point(Shade shade, const glm::vec3& normal, const glm::vec3& material,
                               const Light& light = {}) {
    if (shade == Shade::normal) {
        return {nearest_byte(127.5f + 127.5f * normal.x), nearest_byte(127.5f - 127.5f * normal.y),
                nearest_byte(127.5f - 127.5f * normal.z)};
    }
    const float factor = shade == Shade::flat ? 1.0f : factor_of(light, normal);
    return {nearest_byte(material.x * factor), nearest_byte(material.y * factor),
            nearest_byte(material.z * factor)};
}

// A pixel of `count` samples, and the sums of the colours that they show.  A core sample surely shows the
// surface; a cover sample is in what is drawn larger than the surface, so that no hole can be.
struct PixelSamples {
    uint32_t count = 1, cores = 0, covers = 0;
    glm::u32vec3 core_sum{0}, cover_sum{0};
};

struct MixedPixel {
    glm::u8vec3 rgb;
    uint8_t alpha;
};

// What shows no surface shows the background, which counts by its alpha.  Where an outline passes, so that
// some sample is empty, covers are what is too much of the outline, and do not count.  Where none is, the
// pixel is inside, and a cover is a gap between cores: it counts, by half only where it takes more than a
// quarter of the pixel, which then is an outline that just fills its last pixel.
inline MixedPixel mix(const PixelSamples& s, const Look& look) {
    const uint32_t empty = s.count - s.cores - s.covers;
    const uint32_t share = empty > 0 ? 0 : 4 * s.covers <= s.count ? 2 : 1;  // in halves, as all that follows
    const uint32_t behind = look.background_alpha * (2 * empty + (2 - share) * s.covers);
    const uint32_t weight = 255 * (2 * s.cores + share * s.covers) + behind;
    if (weight == 0) return {look.background, 0};
    const glm::u32vec3 sum =
        255u * (2u * s.core_sum + share * s.cover_sum) + behind * glm::u32vec3(look.background);
    return {(sum + weight / 2) / weight, static_cast<uint8_t>((weight + s.count) / (2 * s.count))};
}

}  // namespace render
