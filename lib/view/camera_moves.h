// Moves of a camera, each a pure function from one camera to the next.
//
// None of them turns a camera that can be drawn (geom::check) into one that cannot: what would leave the
// range in which eye and target can be told apart is cut off at its end.
#pragma once

#include <glm/glm.hpp>

#include "geom/camera.h"
#include "geom/sphere.h"

namespace view {

// Turned round the target, about an axis in view space (x right, y down, z forward; unit length), as if the
// model were turned by `angle` radians the other way.  The distance stays to some roundings; up becomes
// the picture's.
geom::Camera turned(const geom::Camera& camera, const glm::dvec3& axis, double angle);

// Eye and target moved by the same way, world units.
geom::Camera moved(const geom::Camera& camera, const glm::dvec3& way);

// Nearer to a point: distances to it become `factor` times as large (below 1: nearer), the direction stays,
// so that the point keeps its place in the picture.  Of a point nearer than `nearest` (world units, >= 0)
// nothing comes nearer.
geom::Camera approached(const geom::Camera& camera, const glm::dvec3& point, double factor, double nearest);

// With the tangent of half the field of view `factor` times as large, from 1 to 150 degrees.
geom::Camera widened(const geom::Camera& camera, double factor);

// Aimed at a point at the depth of which the camera turns from then on: the eye stays, the target is `point`.
geom::Camera aimed(const geom::Camera& camera, const glm::dvec3& point);

// The point at `depth` before the eye (view z, world units) that is seen at pixel coordinates (px, py).
glm::dvec3 point_at(const geom::View& view, double px, double py, double depth);

}  // namespace view
