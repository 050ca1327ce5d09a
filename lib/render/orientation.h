// On which side of the plane through the eye and an edge does a ray pass?  Exact.
//
// Shewchuk.  Adaptive precision floating-point arithmetic and fast robust geometric predicates.  1997.
#pragma once

#include <glm/glm.hpp>

namespace render {

// The sign (-1, 0, 1) of det(a, b, c) = dot(cross(a, b), c), with the vectors taken as the exact numbers they
// are. About 1 us: for where plain arithmetic cannot tell.  Exact while no product of three coordinates
// overflows and none that is not zero falls below 1e-250.
int orientation(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace render
