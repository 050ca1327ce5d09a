// How a surface point becomes three bytes: one formula for every renderer, so that splats and
// triangles differ by geometry alone.  See Shade in frame.h for what the modes mean.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "render/frame.h"

namespace render {

// What a surface without colour is made of: 0.9 grey, as a (linear) byte value.
inline constexpr float kGreyMaterial = 255.0f * 0.9f;

inline constexpr float kAmbient = 0.05f;
inline constexpr float kDiffuse = 0.95f;

// Nearest byte of a value in 0..255; values a rounding error outside are clamped, NaN is 0.
inline uint8_t nearest_byte(float value) {
    const float v = value > 0.0f ? value : 0.0f;
    // As nearest_bytes() of shading-inl.h does it for vectors, to the bit: what lies a rounding error below
    // a half goes up.  NOLINTNEXTLINE(bugprone-incorrect-roundings)
    return static_cast<uint8_t>(static_cast<int>((v < 255.0f ? v : 255.0f) + 0.5f));
}

// The head light's factor for a view-space unit normal: ambient only where it faces away.
inline float light(float normal_z) {
    const float towards_eye = normal_z < 0.0f ? -normal_z : 0.0f;
    return kAmbient + kDiffuse * towards_eye;
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
inline glm::u8vec3 shade_point(Shade shade, const glm::vec3& normal, const glm::vec3& material) {
    if (shade == Shade::normal) {
        return {nearest_byte(127.5f + 127.5f * normal.x), nearest_byte(127.5f - 127.5f * normal.y),
                nearest_byte(127.5f - 127.5f * normal.z)};
    }
    const float factor = shade == Shade::flat ? 1.0f : light(normal.z);
    return {nearest_byte(material.x * factor), nearest_byte(material.y * factor),
            nearest_byte(material.z * factor)};
}

}  // namespace render
