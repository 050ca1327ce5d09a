// Putting what is near in space near in memory.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "pm/build/manifold.h"

namespace pm {

// Renumbers vertices along a Z-order curve, those in one place in the order they had, and sorts faces by
// their first vertex; `positions` are in unit space, by vertex, and have to be made anew.  Simplifying then
// finds most of what it needs in the caches: on four million faces it takes a third less time.
void sort_by_place(Manifold& surface, std::span<const glm::dvec3> positions);

}  // namespace pm
