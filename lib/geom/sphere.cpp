#include "geom/sphere.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geom {
namespace {

// `for_each(visit)` calls visit(point) for every point, the same ones each time.
template <class ForEach>
Sphere sphere_of(const ForEach& for_each) {
    glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
    for_each([&](const glm::vec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    });
    Sphere sphere;
    sphere.centre = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
    double square = 0;  // squares of floats, even of denormal ones, are within the range of double
    for_each([&](const glm::vec3& p) {
        const glm::dvec3 d = glm::dvec3(p) - sphere.centre;
        square = std::max(square, glm::dot(d, d));
    });
    // The centre, the differences, their squares and the root are each off by a rounding.
    sphere.radius = std::sqrt(square) * (1 + 1e-14);
    return sphere;
}

}  // namespace

Sphere sphere_around(std::span<const glm::vec3> points) {
    if (points.empty()) return {};
    return sphere_of([&](const auto& visit) {
        for (const glm::vec3& p : points) visit(p);
    });
}

Sphere sphere_around(std::span<const glm::vec3> points, std::span<const glm::u32vec3> triangles) {
    if (triangles.empty()) return {};
    return sphere_of([&](const auto& visit) {
        for (const glm::u32vec3& triangle : triangles)
            for (int corner = 0; corner < 3; ++corner) visit(points[triangle[corner]]);
    });
}

}  // namespace geom
