#include "view/picture.h"

#include <algorithm>
#include <cmath>

namespace view {

bool are_same(const std::optional<Lens>& a, const std::optional<Lens>& b) {
    if (!a || !b) return a.has_value() == b.has_value();
    return a->centre_px == b->centre_px && a->radius_px == b->radius_px &&
           a->magnification == b->magnification;
}

bool show_the_same(const Wish& a, const Wish& b) {
    return a.camera.eye == b.camera.eye && a.camera.target == b.camera.target && a.camera.up == b.camera.up &&
           a.camera.fovy_deg == b.camera.fovy_deg && a.camera.near == b.camera.near &&
           a.camera.far == b.camera.far && a.width == b.width && a.height == b.height &&
           a.look.shade == b.look.shade && a.look.background == b.look.background &&
           a.look.key_light == b.look.key_light && a.threshold_px == b.threshold_px;
}

std::optional<double> Picture::depth_at(const glm::dvec2& px) const {
    if (!(px.x >= 0 && px.y >= 0 && px.x < frame.width && px.y < frame.height)) return {};
    const float depth = frame.depth[size_t(px.y) * size_t(frame.width) + size_t(px.x)];
    if (!std::isfinite(depth)) return {};
    return double(depth);
}

geom::View view_of(const Lens& lens, const geom::View& picture) {
    const geom::View larger = geom::subdivided(picture, lens.magnification);
    const int width = std::min(2 * lens.radius_px, larger.width),
              height = std::min(2 * lens.radius_px, larger.height);
    const auto first = [&](double centre, int size, int all) {
        return int(std::clamp(std::round(centre * lens.magnification) - size / 2, 0.0, double(all - size)));
    };
    return geom::part_of(larger, first(lens.centre_px.x, width, larger.width),
                         first(lens.centre_px.y, height, larger.height), width, height);
}

}  // namespace view
