// Taking a view-independent resolution out of a model.
#pragma once

#include <cstdint>
#include <span>

#include "mesh/mesh.h"
#include "pm/front.h"
#include "pm/model.h"

namespace pm {

// The mesh of a front of the model, in world units; vertices that were cut off from each other are one again
// where both are active.  Colours and normals as the model has them.
mesh::Mesh mesh_of(const Model& model, const Front& front);

// The same of the first `splits` details, which is the best mesh of that size that the model has.
mesh::Mesh mesh_of_level(const Model& model, uint32_t splits);

}  // namespace pm
