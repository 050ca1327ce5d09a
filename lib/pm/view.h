// The refinement test: does a view want a node split?  One function for server and client.
//
// Kim, Lee, Kobbelt.  View-dependent mesh streaming with minimal latency, section 5.3 (qrefine); the tests
// are those of Hoppe, View-dependent refinement of progressive meshes, 1997, made conservative: a node is
// left as it is only where no part of the input's surface below it can be seen to be wrong.
#pragma once

#include <glm/glm.hpp>

#include "geom/camera.h"
#include "pm/bounds.h"
#include "pm/format.h"

namespace pm {

// World units.  What is seen is the pyramid from the eye with low.x <= x/z <= high.x and low.y <= y/z <=
// high.y, with x along `right`, y along `down`, z along `forward`; no near plane, no far plane.
struct View {
    glm::dvec3 eye{0};
    glm::dvec3 right{1, 0, 0}, down{0, 1, 0}, forward{0, 0, 1};  // orthonormal
    glm::dvec2 low{-1}, high{1};                                 // tangents
    double tolerance =
        0;  // the largest error, as the tangent of the angle that it is seen under: pixels / focal length

    bool operator==(const View&) const = default;
};

// Of the raster of `view`; threshold_px >= 0.
View make_view(const geom::View& view, double threshold_px);

// Throws core::Error where a view from outside cannot be used: a value that is not finite, axes that are not
// orthonormal within 1e-6, tangents beyond 1e6 or not in order, a tolerance below 0, an eye beyond 1e150.
void check(const View& view);

// What of a view decides: all of it, or the distance and the tolerance alone, as if all could be seen.
enum class Culling : uint8_t { on, off };

enum class Verdict : uint8_t {
    refine,
    accurate,    // its error is seen smaller than the tolerance
    outside,     // its surface is not in the pyramid
    faces_away,  // its surface shows its back
};

// Tests in this order: error, pyramid, cone.  So a node gets `faces_away` only where its cone alone stops it,
// and with ConeCodes{} where the cone is not known `refine`.  Where a value is not finite: refine.
//
// A split is wanted where its own node's verdict is `refine` and so are its parent's and its needs'
// (selection.h): bounds are not nested, the conjunction is.  For two views that differ in tolerance only,
// what the larger tolerance wants the smaller wants too.
class RefinementTest {
  public:
    RefinementTest(const View& view, const Placement& placement, Culling culling = Culling::on);
    Verdict operator()(const NodeBounds& node) const;
    // As the tangent of the angle that it is seen under from the nearest point of the sphere; infinite within
    // it, or where it is not a number.
    double screen_error(const NodeBounds& node) const;

  private:
    glm::dvec3 eye_;        // unit space
    glm::dvec3 inward_[4];  // unit normals of the pyramid's sides
    double tolerance_;
    Culling culling_;
};

}  // namespace pm
