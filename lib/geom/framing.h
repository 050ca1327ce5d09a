// Where to stand so that what is to be seen fills the picture.
#pragma once

#include <span>

#include "geom/camera.h"
#include "geom/sphere.h"

namespace geom {

// The camera that looks along the same direction with the same field of view from the nearest place at which
// all `spheres` (world units) lie within the middle 1 / margin of the picture's width and of its height; what
// they leave free is the same on both sides.  The target is the middle of their depths.  `aspect`: width /
// height of the picture; `margin` >= 1.  `towards` has passed check().
//
// Each side plane of the frustum is moved until it touches the spheres; two that face each other meet in the
// line of the nearest eyes.  Exact but for rounding.  Throws core::Error, as check() does, for spheres that
// have no extent, or none that their coordinates can tell.
Camera framed(const Camera& towards, std::span<const Sphere> spheres, double aspect, double margin);

}  // namespace geom
