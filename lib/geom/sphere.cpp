#include "geom/sphere.h"

#include <algorithm>
#include <cmath>

namespace geom {

Sphere sphere_around(std::span<const glm::vec3> points) {
    Sphere sphere;
    if (points.empty()) return sphere;
    glm::vec3 low = points[0], high = points[0];
    for (const glm::vec3& p : points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    sphere.centre = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
    double square = 0;  // squares of floats, even of denormal ones, are within the range of double
    for (const glm::vec3& p : points) {
        const glm::dvec3 d = glm::dvec3(p) - sphere.centre;
        square = std::max(square, glm::dot(d, d));
    }
    // The centre, the differences, their squares and the root are each off by a rounding.
    sphere.radius = std::sqrt(square) * (1 + 1e-14);
    return sphere;
}

}  // namespace geom
