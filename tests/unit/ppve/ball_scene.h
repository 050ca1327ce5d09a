// A scene that is sampled exactly: a ball of radius 1 about the origin before a plane y = 1 (below it, as y
// grows downwards in pictures and upwards here: y = -1), with a pattern on both.
#pragma once

#include <cmath>
#include <cstdint>

#include "geom/camera.h"
#include "ppve/depth_image.h"
#include "ppve/sampler.h"

namespace ppve::test {

inline Frustum frustum_at(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                          double fovy_deg = 40) {
    return {geom::make_view({eye, target, {0, 1, 0}, fovy_deg}, width, height), Projection::perspective};
}

inline Box scene_bounds() {
    Box box;
    box.low = {-3, -1, -3}, box.high = {3, 1, 3}, box.is_empty = false;
    return box;
}

inline uint32_t colour_at(const glm::dvec3& p) {
    const auto channel = [](double v) { return static_cast<uint32_t>(127.5 + 127 * std::sin(5 * v)); };
    return channel(p.x) | channel(p.y) << 8 | channel(p.z) << 16;
}

// The least distance along the ray, in lengths of `ray`; infinity where it meets nothing.  `normal` is set.
inline double hit(const glm::dvec3& eye, const glm::dvec3& ray, glm::dvec3& normal) {
    double t = INFINITY;
    const double a = glm::dot(ray, ray), b = glm::dot(eye, ray), c = glm::dot(eye, eye) - 1;
    if (const double root = b * b - a * c; root >= 0)
        if (const double s = (-b - std::sqrt(root)) / a; s > 0) t = s, normal = eye + s * ray;
    const double s = (-1 - eye.y) / ray.y;
    const glm::dvec3 p = eye + s * ray;
    if (s > 0 && s < t && std::fabs(p.x) <= 3 && std::fabs(p.z) <= 3) t = s, normal = {0, 1, 0};
    return t;
}

inline DepthImage sample(const Frustum& frustum, bool with_normals = false, double footprint_px = 1) {
    DepthImage image;
    image.frustum = frustum;
    image.footprint_px = footprint_px;
    image.coding = choose_coding(frustum, 0.01, 0.01, 100);
    image.clear(with_normals);
    const geom::View& view = frustum.view;
    const glm::dvec2 principal = view.principal_in_raster();
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const glm::dvec3 ray = view.right * ((x + 0.5 - principal.x) / view.focal_px) +
                                   view.down * ((y + 0.5 - principal.y) / view.focal_px) + view.forward;
            glm::dvec3 normal(0);
            const double z = hit(view.eye, ray, normal);
            if (!std::isfinite(z)) continue;
            const size_t i = size_t(y) * size_t(view.width) + size_t(x);
            image.depth[i] = image.coding.code(z);
            image.colour[i] = colour_at(view.eye + z * ray);
            if (with_normals) image.normal[i] = octahedral_code(glm::vec3(normal));
        }
    return image;
}

}  // namespace ppve::test
