#include "ppve/client/patch_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppve {

namespace {

// Samples in rows from the top, in a row from the left, as a patch has them.
struct GridPoints {
    struct Place {
        int x, y;
        double depth;
    };
    std::vector<Place> places;
    PatchPoints points;  // without positions
};

// Squares of 2 x 2 samples, being summed.
struct Square {
    int x;
    double depth = std::numeric_limits<double>::infinity();
    uint32_t count = 0;
    glm::u32vec3 colour{0};
    glm::vec3 normal{0};

    void add(const GridPoints& from, size_t i) {
        ++count;
        depth = std::min(depth, from.places[i].depth);
        const uint32_t c = from.points.colour[i];
        colour += glm::u32vec3(c & 0xff, c >> 8 & 0xff, c >> 16 & 0xff);
        if (from.points.has_normals()) normal += octahedral_normal(from.points.normal[i]);
    }
    uint32_t mean_colour() const {
        const glm::u32vec3 mean = (colour + count / 2) / count;
        return mean.x | mean.y << 8 | mean.z << 16;
    }
};

size_t end_of_row(const GridPoints& grid, size_t i, int y) {
    while (i < grid.places.size() && grid.places[i].y == y) ++i;
    return i;
}

void append(const Square& square, int y, bool with_normals, GridPoints& to) {
    to.places.push_back({square.x, y, square.depth});
    to.points.colour.push_back(square.mean_colour());
    if (with_normals) to.points.normal.push_back(octahedral_code(square.normal));
}

GridPoints halved(const GridPoints& from) {
    GridPoints to;
    const bool with_normals = from.points.has_normals();
    for (size_t i = 0; i < from.places.size();) {
        // The two rows of a row of squares; one of them may be missing.
        const int upper = from.places[i].y & ~1;
        size_t a = i;
        const size_t a_end = end_of_row(from, i, upper);
        size_t b = a_end;
        const size_t b_end = end_of_row(from, b, upper + 1);
        while (a < a_end || b < b_end) {
            const int left = a < a_end ? from.places[a].x >> 1 : std::numeric_limits<int>::max();
            const int right = b < b_end ? from.places[b].x >> 1 : std::numeric_limits<int>::max();
            Square square{std::min(left, right)};
            for (; a < a_end && from.places[a].x >> 1 == square.x; ++a) square.add(from, a);
            for (; b < b_end && from.places[b].x >> 1 == square.x; ++b) square.add(from, b);
            append(square, upper >> 1, with_normals, to);
        }
        i = b_end;
    }
    return to;
}

GridPoints grid_of(const Patch& patch, double unit) {
    GridPoints grid;
    const PatchPoints& p = patch.points();
    grid.places.reserve(p.size());
    for (size_t i = 0; i < p.size(); ++i) {
        const Projected at =
            project(patch.sampling().frustum, patch.anchor() + glm::dvec3(p.x[i], p.y[i], p.z[i]) * unit);
        grid.places.push_back(
            {static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)), at.depth});
    }
    grid.points.colour = p.colour;
    grid.points.normal = p.normal;
    return grid;
}

// Squares are where their middles are, at their least depth.
PatchPoints placed(GridPoints grid, const Patch& patch, double unit, int across) {
    const Frustum& frustum = patch.sampling().frustum;
    const geom::View& view = frustum.view;
    PatchPoints points = std::move(grid.points);
    for (const GridPoints::Place& place : grid.places) {
        const bool is_perspective = frustum.projection == Projection::perspective;
        const glm::dvec2 at = ((glm::dvec2(place.x, place.y) + 0.5) * double(across) - view.principal()) *
                              ((is_perspective ? place.depth : 1) / view.focal_px);
        const glm::dvec3 world = view.eye + view.right * at.x + view.down * at.y + view.forward * place.depth;
        const glm::vec3 offset((world - patch.anchor()) / unit);
        points.x.push_back(offset.x);
        points.y.push_back(offset.y);
        points.z.push_back(offset.z);
    }
    return points;
}

NormalCone cone_of(const Patch& patch, double unit) {
    const PatchPoints& p = patch.points();
    if (!p.has_normals()) return {};
    const Frustum& frustum = patch.sampling().frustum;
    const auto turned = [&](size_t i) {
        const glm::vec3 normal = octahedral_normal(p.normal[i]);
        const glm::dvec3 ray =
            frustum.projection == Projection::orthographic
                ? frustum.view.forward
                : patch.anchor() + glm::dvec3(p.x[i], p.y[i], p.z[i]) * unit - frustum.view.eye;
        return glm::dot(glm::dvec3(normal), ray) > 0 ? -normal : normal;
    };
    glm::vec3 sum(0);
    for (size_t i = 0; i < p.size(); ++i) sum += turned(i);
    if (!(glm::length(sum) > 1e-3f * float(p.size()))) return {};
    NormalCone cone{glm::normalize(sum), 1};
    for (size_t i = 0; i < p.size(); ++i) {
        if (p.normal[i] == kUnknownNormal) return {};
        cone.cos_half_angle = std::min(cone.cos_half_angle, glm::dot(cone.axis, turned(i)));
    }
    // Normals are rounded to 0.017 radians.
    const float half_angle = std::acos(std::clamp(cone.cos_half_angle, -1.0f, 1.0f)) + 0.02f;
    cone.cos_half_angle = half_angle < 3.14f ? std::cos(half_angle) : -1;
    return cone;
}

size_t bytes_of(const PatchPoints& p) {
    return (p.x.capacity() + p.y.capacity() + p.z.capacity()) * sizeof(float) +
           p.colour.capacity() * sizeof(uint32_t) + p.normal.capacity() * sizeof(uint16_t);
}

}  // namespace

size_t PatchLevels::bytes() const {
    size_t sum = sizeof *this;
    for (const PatchPoints& level : coarser) sum += bytes_of(level);
    return sum;
}

std::shared_ptr<const PatchLevels> decimate(std::shared_ptr<const Patch> patch, double unit) {
    auto levels = std::make_shared<PatchLevels>();
    GridPoints grid = grid_of(*patch, unit);
    for (size_t k = 1; k <= kMostCoarser; ++k) {
        GridPoints next = halved(grid);
        // Scattered samples do not grow fewer.
        if (4 * next.places.size() > 3 * grid.places.size()) break;
        levels->coarser.push_back(placed(next, *patch, unit, 1 << k));
        grid = std::move(next);
    }
    levels->cone = cone_of(*patch, unit);
    levels->patch = std::move(patch);
    return levels;
}

bool faces_away(const PatchLevels& levels, const glm::dvec3& eye, double unit) {
    const NormalCone& cone = levels.cone;
    if (!(cone.cos_half_angle > 0)) return false;
    const Patch& patch = *levels.patch;
    const glm::dvec3 low(patch.low()), high(patch.high());
    const glm::dvec3 to_eye = (eye - patch.anchor()) / unit - 0.5 * (low + high);
    const double radius = 0.5 * glm::length(high - low), distance = glm::length(to_eye);
    if (!(distance > radius)) return false;
    // Over the patch the direction to the eye turns by asin(radius / distance), the normal by the cone's half
    // angle; the two add up.
    const double spread = std::acos(double(cone.cos_half_angle)) + std::asin(radius / distance);
    const double between =
        std::acos(std::clamp(glm::dot(glm::dvec3(cone.axis), to_eye) / distance, -1.0, 1.0));
    return between - spread > 0.5 * 3.14159265358979324;
}

}  // namespace ppve
