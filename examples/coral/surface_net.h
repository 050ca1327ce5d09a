// The surface of a reef as triangles: surface nets on a sparse lattice.
//
// Gibson.  Constrained elastic surface nets.  1998.  One vertex in every lattice cell that the surface
// crosses, one quadrilateral round every lattice edge that it crosses: closed, with every edge shared
// by an even number of triangles.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "reef.h"

namespace coral {

struct ColouredMesh {
    std::vector<glm::vec3> positions;
    std::vector<glm::u8vec3> colours;     // one a vertex, sRGB
    std::vector<glm::u32vec3> triangles;  // counter-clockwise from outside
};

// `resolution`: lattice cells along the longest side of the reef's bounds, at least 64.  Time and size
// go with its square.  The same for any number of threads.
ColouredMesh triangulate(const Reef& reef, int resolution);

}  // namespace coral
