// The share of a face that belongs to one of its corners: the part nearer to it than to the other
// two.  Shares are convex, so an ellipsoid that holds the corners of a share holds the share; the
// shares of all leaves cover the surface.
#pragma once

#include <glm/glm.hpp>

namespace splat {

// Corners of the share of vertex 0 in the face (0, p, q), without the vertex itself.  Needle and
// zero-area faces give the whole face.  Lengths in double, from 1e-75 to 1e75.
struct Share {
    glm::dvec3 corner[4];
    int count = 0;
};
inline Share share_of(const glm::dvec3& p, const glm::dvec3& q) {
    const double pp = glm::dot(p, p), qq = glm::dot(q, q), pq = glm::dot(p, q);
    const double at_p = pp - pq, at_q = qq - pq;  // cosines of the angles at p and q, times lengths
    const double area2 = pp * qq - pq * pq;
    if (!(area2 > 1e-18 * pp * qq)) return {{p, q}, 2};
    if (pq <= 0) {  // obtuse here: two points on the far edge
        const double s = 0.5 * pp / at_p, t = 0.5 * qq / at_q;
        return {{0.5 * p, 0.5 * q, p + s * (q - p), q + t * (p - q)}, 4};
    }
    if (at_p <= 0) return {{0.5 * p, (0.5 * pp / pq) * q}, 2};  // obtuse at p
    if (at_q <= 0) return {{0.5 * q, (0.5 * qq / pq) * p}, 2};
    const glm::dvec3 circumcentre = (qq * at_p * p + pp * at_q * q) / (2 * area2);
    return {{0.5 * p, 0.5 * q, circumcentre}, 3};
}

}  // namespace splat
