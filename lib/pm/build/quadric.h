// Quadrics: the weighted sum of squared distances from planes.
//
// Garland, Heckbert.  Surface simplification using quadric error metrics.  1997.  Evaluated at vertices that
// exist, never minimised, so a singular one is as good as any.
#pragma once

#include <algorithm>
#include <glm/glm.hpp>

namespace pm {

struct Quadric {
    // Of x' A x + 2 b' x + c.
    double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
    glm::dvec3 b{0};
    double c = 0;

    // The plane through `point` with a unit normal, `weight` times.
    static Quadric plane(const glm::dvec3& normal, const glm::dvec3& point, double weight) {
        const double d = -glm::dot(normal, point);
        const glm::dvec3 n = weight * normal;
        return {n.x * normal.x, n.y * normal.y, n.z * normal.z, n.x * normal.y,
                n.x * normal.z, n.y * normal.z, d * n,          weight * d * d};
    }

    Quadric& operator+=(const Quadric& o) {
        xx += o.xx, yy += o.yy, zz += o.zz, xy += o.xy, xz += o.xz, yz += o.yz;
        b += o.b, c += o.c;
        return *this;
    }

    // 0 or more: rounding may leave a little less.
    double operator()(const glm::dvec3& p) const {
        const double squares = xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z;
        const double products = xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z;
        return std::max(0.0, squares + 2 * (products + glm::dot(b, p)) + c);
    }
};

}  // namespace pm
