// Bounding spheres.
#pragma once

#include <glm/glm.hpp>

namespace geom {

// Centre and radius in the caller's units; radius >= 0.
struct Sphere {
    glm::dvec3 centre{0};
    double radius = 0;
};

}  // namespace geom
