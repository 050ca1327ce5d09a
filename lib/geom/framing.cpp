#include "geom/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geom {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Across a picture, and from its eye into it.
struct Place {
    double across, depth;
};

// The two planes of a frustum that face each other across one side of the picture, as they touch what is
// seen.
class Wedge {
  public:
    explicit Wedge(double tangent) : cosine_(1 / std::hypot(1, tangent)), sine_(tangent * cosine_) {}

    void hold(double across, double depth, double radius) {
        above_ = std::max(above_, across * cosine_ - depth * sine_ + radius);
        below_ = std::max(below_, -across * cosine_ - depth * sine_ + radius);
    }
    // Where the planes meet: from further back all is still between them.
    Place eye() const { return {(above_ - below_) / (2 * cosine_), -(above_ + below_) / (2 * sine_)}; }

  private:
    double cosine_, sine_;
    double above_ = -kInfinity, below_ = -kInfinity;
};

}  // namespace

Camera framed(const Camera& towards, std::span<const Sphere> spheres, double aspect, double margin) {
    const View view = make_view(towards, 1, 1);
    const double tangent = std::tan(0.5 * towards.fovy_deg * std::acos(-1.0) / 180) / margin;
    Wedge horizontal(tangent * aspect), vertical(tangent);
    double nearest = kInfinity, farthest = -kInfinity;
    for (const Sphere& sphere : spheres) {
        // About the target, not the eye: what is far from the origin keeps its digits.
        const glm::dvec3 d = sphere.centre - towards.target;
        const double depth = glm::dot(view.forward, d);
        horizontal.hold(glm::dot(view.right, d), depth, sphere.radius);
        vertical.hold(glm::dot(view.down, d), depth, sphere.radius);
        nearest = std::min(nearest, depth - sphere.radius);
        farthest = std::max(farthest, depth + sphere.radius);
    }
    const Place x = horizontal.eye(), y = vertical.eye();
    const glm::dvec3 axis = towards.target + x.across * view.right + y.across * view.down;
    Camera camera = towards;
    camera.eye = axis + std::min(x.depth, y.depth) * view.forward;
    camera.target = axis + 0.5 * (nearest + farthest) * view.forward;
    check(camera);
    return camera;
}

}  // namespace geom
