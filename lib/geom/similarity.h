// Placing one thing in the space of another: rotation, uniform scale, translation, mirror images too.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <string_view>

#include "geom/camera.h"
#include "geom/sphere.h"

namespace geom {

// outer = translation + scale * rotation * inner.  `rotation` is orthonormal within 1e-15 (a mirror image's
// has the determinant -1); scale > 0.
struct Similarity {
    glm::dmat3 rotation{1};
    double scale = 1;
    glm::dvec3 translation{0};

    glm::dvec3 point(const glm::dvec3& inner) const { return translation + scale * (rotation * inner); }
    glm::dvec3 inverse_point(const glm::dvec3& outer) const {
        return glm::transpose(rotation) * ((outer - translation) / scale);
    }
};

// The same view, in the inner space.
View view_in(const Similarity& outer_from_inner, const View& view);

// The outer sphere of an inner one.
Sphere placed(const Sphere& inner, const Similarity& outer_from_inner);

// A sphere around both, at most a few roundings larger than the smallest.
Sphere sphere_around(const Sphere& a, const Sphere& b);

// From text: numbers with a comma or white space between, as many as
//     3    X Y Z, a translation
//     4    X Y Z SCALE
//     7    X Y Z SCALE RX RY RZ: turned first about x, then about y, then about z, in degrees,
//     counter-clockwise as seen
//          from the axis' positive end
//     16   a 4 x 4 matrix, row by row, that takes column vectors: the last row is 0 0 0 1
// A matrix is taken for the nearest similarity if it is one to within 1e-5; others (that shear, or scale
// unevenly) are refused.  So are a scale that is not from 1e-100 to 1e100 and what is not finite or beyond
// 1e150.  Throws core::Error "<name>: ...".
Similarity parse_similarity(std::string_view text, const std::string& name);

}  // namespace geom
