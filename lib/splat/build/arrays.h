// Points as structures of arrays, for loops in SIMD.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace splat {

constexpr size_t kSpare = 16;  // floats of the widest vector that is used

// Whole vectors are loaded: behind the last point there must be room for kSpare more.
struct PointArrays {
    std::vector<float> x, y, z;
    size_t size() const { return x.size(); }
    void resize(size_t n) { x.resize(n), y.resize(n), z.resize(n); }
    void set(size_t i, const glm::vec3& p) { x[i] = p.x, y[i] = p.y, z[i] = p.z; }
    glm::vec3 get(size_t i) const { return {x[i], y[i], z[i]}; }
};

}  // namespace splat
