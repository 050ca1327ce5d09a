// Bounding spheres.
#pragma once

#include <glm/glm.hpp>
#include <span>

namespace geom {

// Centre and radius in the caller's units; radius >= 0.
struct Sphere {
    glm::dvec3 centre{0};
    double radius = 0;
};

// About the middle of the points' bounding box, with the distance of the farthest point, rounded up: it
// holds every point, and is at most twice the smallest sphere that does.  `points` are finite; without
// points it is a point at 0.  One pass for the box, one for the radius.
Sphere sphere_around(std::span<const glm::vec3> points);

// The same of the triangles' corners only; `triangles` are indices of `points`, all in range.
Sphere sphere_around(std::span<const glm::vec3> points, std::span<const glm::u32vec3> triangles);

}  // namespace geom
