// Cameras of many sizes and directions, the same each time.
#pragma once

#include <random>

#include "geom/camera.h"

inline geom::Camera some_camera(std::mt19937_64& random, double size) {
    std::normal_distribution<double> normal;
    const auto vector = [&] { return size * glm::dvec3(normal(random), normal(random), normal(random)); };
    geom::Camera camera;
    camera.target = vector();
    camera.eye = camera.target + vector() + glm::dvec3(0, 0, size);
    camera.up = {normal(random), normal(random), normal(random)};
    camera.fovy_deg = 40;
    return camera;
}

// Where a point is seen, pixels.
inline glm::dvec2 seen_at(const geom::View& view, const glm::dvec3& point) {
    const glm::dvec3 p = view.view_from_world(point);
    const glm::dvec2 middle = view.principal_in_raster();
    return {middle.x + view.focal_px * p.x / p.z, middle.y + view.focal_px * p.y / p.z};
}
