#include "scene/shots.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace scene {
namespace {

// Where the `index`-th of `count` parts of `size` pixels begins.
int part_begin(int size, int index, int count) {
    return int(int64_t{size} * index / count);
}

// Each row of `a`, of so many values, with that of `b` behind it.
template <class T>
std::vector<T> join_rows(const std::vector<T>& a, const std::vector<T>& b, size_t row_a, size_t row_b) {
    std::vector<T> both;
    both.reserve(a.size() + b.size());
    for (size_t at_a = 0, at_b = 0; at_a < a.size(); at_a += row_a, at_b += row_b) {
        both.insert(both.end(), a.begin() + std::ptrdiff_t(at_a), a.begin() + std::ptrdiff_t(at_a + row_a));
        both.insert(both.end(), b.begin() + std::ptrdiff_t(at_b), b.begin() + std::ptrdiff_t(at_b + row_b));
    }
    return both;
}

}  // namespace

geom::View tile_of(const geom::View& picture, const Tile& tile) {
    const int left = part_begin(picture.width, tile.x, tile.across);
    const int top = part_begin(picture.height, tile.y, tile.down);
    return geom::part_of(picture, left, top, part_begin(picture.width, tile.x + 1, tile.across) - left,
                         part_begin(picture.height, tile.y + 1, tile.down) - top);
}

std::vector<EyeView> views_of(const geom::Camera& camera, const Screen& screen) {
    const geom::View middle = geom::make_view(camera, screen.width, screen.height);
    if (!screen.is_stereo) return {{"", tile_of(middle, screen.tile)}};
    const double distance = glm::length(camera.target - camera.eye);
    const double offset = distance * std::tan(0.5 * screen.eye_angle_deg * (std::numbers::pi / 180));
    return {{"left", tile_of(geom::moved_aside(middle, -offset, distance), screen.tile)},
            {"right", tile_of(geom::moved_aside(middle, offset, distance), screen.tile)}};
}

void put_side_by_side(const render::Frame& left, const render::Frame& right, render::Frame& both) {
    const size_t width_left = size_t(left.width), width_right = size_t(right.width);
    both.width = left.width + right.width, both.height = left.height;
    both.rgb = join_rows(left.rgb, right.rgb, 3 * width_left, 3 * width_right);
    both.alpha = join_rows(left.alpha, right.alpha, width_left, width_right);
    both.depth = join_rows(left.depth, right.depth, width_left, width_right);
    both.depth_at = left.depth_at;
}

}  // namespace scene
