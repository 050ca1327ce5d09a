// Noise of a lattice: the same on every machine, no tables.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace coral {

// splitmix64 (Steele, Lea, Flood 2014), as a generator and as a hash.
class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed) {}
    uint64_t next() {
        uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    // In [0, 1).
    float unit() { return static_cast<float>(next() >> 40) * 0x1p-24f; }
    float within(float low, float high) { return low + (high - low) * unit(); }
    // In the unit ball.
    glm::vec3 in_ball() {
        for (;;) {
            const float x = within(-1, 1), y = within(-1, 1), z = within(-1, 1);
            const glm::vec3 p(x, y, z);
            if (glm::dot(p, p) < 1) return p;
        }
    }

  private:
    uint64_t state_;
};

inline uint32_t hash(glm::ivec3 cell) {
    uint32_t h = static_cast<uint32_t>(cell.x) * 0x8da6b343u ^ static_cast<uint32_t>(cell.y) * 0xd8163841u ^
                 static_cast<uint32_t>(cell.z) * 0xcb1ab31fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return h ^ (h >> 15);
}

// A byte of a hash as a number in [0, 1).
inline float fraction(uint32_t h, int byte) {
    return static_cast<float>((h >> (8 * byte)) & 255) / 256.0f;
}

// Smooth noise in [-1, 1], features about 1 wide: values at lattice points, quintic between them.
inline float value_noise(glm::vec3 p) {
    const glm::vec3 floor = glm::floor(p), f = p - floor;
    const glm::ivec3 cell(floor);
    const glm::vec3 w = f * f * f * (f * (f * 6.0f - 15.0f) + 10.0f);
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 at(corner & 1, (corner >> 1) & 1, corner >> 2);
        const float weight = (at.x ? w.x : 1 - w.x) * (at.y ? w.y : 1 - w.y) * (at.z ? w.z : 1 - w.z);
        sum += weight * static_cast<float>(hash(cell + at) & 0xffff);
    }
    return sum / 32768.0f - 1;
}

// Octaves of value noise, each half as wide and half as strong; in [-1, 1].
inline float fractal_noise(glm::vec3 p, int octaves) {
    float sum = 0, strength = 0.5f;
    for (int octave = 0; octave < octaves; ++octave, strength *= 0.5f) {
        sum += strength * value_noise(p);
        p = p * 2.0f + 17.3f;
    }
    return sum;
}

// Distance to the nearest of a random set of points, one in each unit cell (Worley 1996); about 0 to 1.
inline float nearest_point(glm::vec3 p) {
    const glm::vec3 floor = glm::floor(p), f = p - floor;
    const glm::ivec3 cell(floor);
    float best = 4;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                const uint32_t h = hash(cell + glm::ivec3(x, y, z));
                const glm::vec3 point(static_cast<float>(x) + fraction(h, 0),
                                      static_cast<float>(y) + fraction(h, 1),
                                      static_cast<float>(z) + fraction(h, 2));
                const glm::vec3 d = point - f;
                best = std::min(best, glm::dot(d, d));
            }
    return std::sqrt(best);
}

}  // namespace coral
