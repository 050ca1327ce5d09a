// The light of depth images: fixed to the scene, so that samples of different views agree, and falling on
// both sides of a surface, so that a mesh with turned triangles has no black ones.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace ppve {

inline constexpr glm::vec3 kTowardsLight{0.36f, 0.48f, 0.8f};  // unit, world space
inline constexpr float kAmbient = 0.25f;

// Colours are 0x00BBGGRR.
inline uint32_t pack_colour(const glm::vec3& bytes) {
    uint32_t packed = 0;
    for (int k = 0; k < 3; ++k) packed |= uint32_t(glm::clamp(bytes[k], 0.0f, 255.0f) + 0.5f) << 8 * k;
    return packed;
}

// `normal`: unit, or zero where it is unknown, which is lit in full.
inline uint32_t lit_colour(const glm::vec3& material, const glm::vec3& normal) {
    const float towards = normal == glm::vec3(0) ? 1.0f : std::abs(glm::dot(normal, kTowardsLight));
    return pack_colour(material * (kAmbient + (1 - kAmbient) * towards));
}

}  // namespace ppve
