// What bare points lack: a radius and a normal, from their nearest neighbours.
#pragma once

#include <vector>

#include "mesh/mesh.h"

namespace splat {

// A radius a point, world units: large enough to touch the neighbours (0.8 of the distance to the 6th of
// them, at most 4 times that of the 3 nearest; equal points count once and share it; 0 if all points are
// equal).  Fills mesh.normals where there are none, by the plane of least squares through 12 neighbours,
// turned to the upper half space (z, then y, then x); 0 for points that have none, with neighbours along a
// line.  Of up to two points none has, and mesh.normals stays empty.
std::vector<float> estimate_discs(mesh::Mesh& mesh);

}  // namespace splat
