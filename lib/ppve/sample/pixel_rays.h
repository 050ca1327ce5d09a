// The rays through the centres of a frustum's pixels, for samplers that cast them.
#pragma once

#include <algorithm>
#include <limits>

#include "ppve/depth_image.h"

namespace ppve {

// origin + t * direction is at depth t (from the eye's plane): direction has depth 1.
struct PixelRay {
    glm::dvec3 origin, direction;
};

inline PixelRay pixel_ray(const Frustum& f, int i, int j) {
    const geom::View& v = f.view;
    const glm::dvec2 at = (glm::dvec2(i + 0.5, j + 0.5) - v.principal()) / v.focal_px;
    const glm::dvec3 aside = v.right * at.x + v.down * at.y;
    if (f.projection == Projection::orthographic) return {v.eye + aside, v.forward};
    return {v.eye, v.forward + aside};
}

// Depths between which a ray is in a box; empty where first > last.
struct DepthInterval {
    double first, last;
};

inline DepthInterval clip(const PixelRay& ray, const glm::dvec3& low, const glm::dvec3& high,
                          DepthInterval within) {
    for (int k = 0; k < 3; ++k) {
        if (ray.direction[k] == 0) {
            if (ray.origin[k] < low[k] || ray.origin[k] > high[k]) return {1, 0};
            continue;
        }
        const double a = (low[k] - ray.origin[k]) / ray.direction[k],
                     b = (high[k] - ray.origin[k]) / ray.direction[k];
        within.first = std::max(within.first, std::min(a, b)),
        within.last = std::min(within.last, std::max(a, b));
    }
    return within;
}

}  // namespace ppve
