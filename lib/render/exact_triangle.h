// A triangle against the rays through the centres of pixels, exactly: what MeshRaster promises, for all who
// draw triangles.
//
// A pixel is covered where its ray meets the triangle before the eye, decided by the sign of three
// determinants of the corners.  A sign that plain arithmetic cannot tell is asked of orientation(), so that
// triangles that share the bits of two corners share their edge without a crack, and without covering
// anything twice.
//
// Olano, Greer.  Triangle scan conversion using 2D homogeneous coordinates.  1997.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

#include "geom/camera.h"
#include "render/orientation.h"

namespace render {

// A determinant of three vectors, each component rounded a handful of times, is off by less than this times
// the product of their magnitudes: six products, each with at most six roundings of 2^-53, and some room.
inline constexpr double kRounding = 48 * 0x1p-53;

// A vertex in view space, in units of the frame's scale: (focal_px * x, focal_px * y, z).  The ray through
// pixel centre (X, Y), counted from the middle of the frame, is (X, Y, 1) in these coordinates.
using Ray = glm::dvec3;

inline Ray ray_of(const geom::View& view, double x, double y, double z) {
    return {view.focal_px * x, view.focal_px * y, z};
}

// Where a vertex falls among the pixel centres: those at or right of (below) it begin at `first`, those at or
// left of (above) it end at `last`, give or take the rounding of the projection.  The ends are kept as ~last,
// so that the box of a triangle is the least of each of its vertices' four numbers.
struct Span {
    int32_t first_x, first_y, not_last_x, not_last_y;
};

// first_x of a vertex at or behind the eye, which has no place on the screen.
inline constexpr int32_t kBehind = std::numeric_limits<int32_t>::min();

inline Span least(const Span& a, const Span& b) {
    return {std::min(a.first_x, b.first_x), std::min(a.first_y, b.first_y),
            std::min(a.not_last_x, b.not_last_x), std::min(a.not_last_y, b.not_last_y)};
}

// Pixels [first_x, last_x] x [first_y, last_y]; empty where last < first.
struct PixelBox {
    int first_x, first_y, last_x, last_y;
    bool empty() const { return last_x < first_x || last_y < first_y; }
};

inline PixelBox intersect(const PixelBox& a, const PixelBox& b) {
    return {std::max(a.first_x, b.first_x), std::max(a.first_y, b.first_y), std::min(a.last_x, b.last_x),
            std::min(a.last_y, b.last_y)};
}

// A frame's raster and what follows from its size and its place in the picture.
struct Raster {
    int width, height;
    int left, top;         // first pixel
    glm::dvec2 principal;  // where X and Y are 0
    double reach;          // no pixel centre has |X| or |Y| above it
    double slack;          // pixels by which a projection may be off inside the frame, generously
    double near, far;      // depths, in the frame's scale, between which something is drawn

    Raster(const geom::View& view, double scale)
        : width(view.width),
          height(view.height),
          left(view.margins.left),
          top(view.margins.top),
          principal(view.principal()),
          reach(std::max(std::max(std::abs(side_x(-1)), std::abs(side_x(1))),
                         std::max(std::abs(side_y(-1)), std::abs(side_y(1))))),
          slack(reach * 0x1p-40),
          near(view.near.value_or(0) * scale),
          far(view.far.value_or(std::numeric_limits<double>::infinity()) * scale) {}

    PixelBox all() const { return {0, 0, width - 1, height - 1}; }
    // X and Y of pixel centres, and of the raster's left (-1) or right (1), upper or lower side.
    double centre_x(int i) const { return left + i + 0.5 - principal.x; }
    double centre_y(int j) const { return top + j + 0.5 - principal.y; }
    double side_x(double sign) const { return left + (sign > 0 ? width : 0) - principal.x; }
    double side_y(double sign) const { return top + (sign > 0 ? height : 0) - principal.y; }
};

// The first of `count` pixels along an axis whose centre is at or after `place` (pixels from the edge of the
// frame), and the last whose centre is at or before it; `count` and -1 where there is none.  Written so that
// anything, NaN too, gives numbers in these ranges.
inline int32_t first_after(double place, int count) {
    if (!(place > 0.5)) return 0;
    if (place > count - 0.5) return count;
    const int32_t before = int32_t(place - 0.5);
    return before + (before + 0.5 < place);
}

inline int32_t last_before(double place, int count) {
    if (!(place < count - 0.5)) return count - 1;
    return place < 0.5 ? -1 : int32_t(place - 0.5);
}

inline Span span_of(const Raster& raster, const Ray& ray) {
    if (!(ray.z > 0)) return {kBehind, 0, 0, 0};
    const double inverse = 1 / ray.z;
    const double x = ray.x * inverse - raster.side_x(-1), y = ray.y * inverse - raster.side_y(-1);
    return {first_after(x - raster.slack, raster.width), first_after(y - raster.slack, raster.height),
            ~last_before(x + raster.slack, raster.width), ~last_before(y + raster.slack, raster.height)};
}

// True if v lies outside the side of the view pyramid where sign * (coordinate - place * z) = 0, beyond
// doubt.
inline bool beyond(double coordinate, double z, double place, double sign) {
    const double margin = kRounding * (std::abs(coordinate) + std::abs(place * z));
    return sign * (coordinate - place * z) > margin;
}

// The pixels that a triangle reaching behind the eye may cover: none, where one side of the view pyramid
// (which goes through the eye, so the test holds behind it too) has it wholly outside, else all.
inline PixelBox box_across_eye(const Raster& raster, const Ray& a, const Ray& b, const Ray& c) {
    const PixelBox none{0, 0, -1, -1};
    if (a.z <= 0 && b.z <= 0 && c.z <= 0) return none;
    for (const double sign : {-1.0, 1.0}) {
        const double w = raster.side_x(sign), h = raster.side_y(sign);
        if (beyond(a.x, a.z, w, sign) && beyond(b.x, b.z, w, sign) && beyond(c.x, c.z, w, sign)) return none;
        if (beyond(a.y, a.z, h, sign) && beyond(b.y, b.z, h, sign) && beyond(c.y, c.z, h, sign)) return none;
    }
    return raster.all();
}

// The pixels that a triangle may cover; `all`: the least of its corners' spans.
inline PixelBox box_of(const Raster& raster, const Span& all, const Ray& a, const Ray& b, const Ray& c) {
    if (all.first_x == kBehind) return box_across_eye(raster, a, b, c);
    return {all.first_x, all.first_y, ~all.not_last_x, ~all.not_last_y};
}

// A triangle ready to be drawn.  Edge i is opposite vertex i; value(i, X, Y) > 0 where the ray through (X, Y)
// passes on the triangle's side of it.  A ray inside all edges meets the triangle before the eye, because the
// values have been given the sign of the triangle's determinant, and they are the perspective-correct weights
// of the vertices.
struct TriangleSetup {
    const Ray* vertices[3];
    glm::dvec3 normals[3];     // sign * cross product of the edge's ends
    glm::dvec3 rounding;       // value(i) is off by at most rounding[i]
    double sign;               // 1 or -1
    double nearest, farthest;  // depths

    // False for a triangle that is seen edge-on or has no area: it covers nothing.
    [[gnu::always_inline]] bool set(const Raster& raster, const Ray& a, const Ray& b, const Ray& c) {
        vertices[0] = &a, vertices[1] = &b, vertices[2] = &c;
        const double ma = magnitude(raster, a), mb = magnitude(raster, b), mc = magnitude(raster, c);
        normals[0] = glm::cross(b, c), normals[1] = glm::cross(c, a), normals[2] = glm::cross(a, b);
        rounding[0] = kRounding * mb * mc, rounding[1] = kRounding * mc * ma,
        rounding[2] = kRounding * ma * mb;
        const double det = glm::dot(normals[0], a);
        const double doubt = rounding[0] * ma / raster.reach;
        sign = std::copysign(1.0, det);
        if (!(std::abs(det) > doubt)) {
            sign = orientation(a, b, c);
            if (sign == 0) return false;
        }
        for (glm::dvec3& normal : normals) normal *= sign;
        nearest = std::max(0.0, std::min(std::min(a.z, b.z), c.z));
        farthest = std::max(std::max(a.z, b.z), c.z);
        return true;
    }

    double value(int edge, double x, double y) const {
        return normals[edge].x * x + (normals[edge].y * y + normals[edge].z);
    }

    // `values`: those at (x, y).  One branch that cannot be foreseen instead of three: -15% on the draw pass.
    bool inside(const glm::dvec3& values, double x, double y) const {
        if (least(values + rounding) < 0) return false;
        if (least(values - rounding) > 0) return true;
        return inside_exactly(0, x, y) && inside_exactly(1, x, y) && inside_exactly(2, x, y);
    }

    // A ray on the edge counts as if it were moved to the right by an infinitely small amount, and down by
    // one infinitely smaller.
    [[gnu::noinline]] bool inside_exactly(int edge, double x, double y) const {
        const Ray &from = *vertices[(edge + 1) % 3], &to = *vertices[(edge + 2) % 3];
        int side = orientation(from, to, {x, y, 1});
        if (side == 0) side = orientation(from, to, {1, 0, 0});
        if (side == 0) side = orientation(from, to, {0, 1, 0});
        return side * sign > 0;
    }

    // Where the ray through (x, y) meets the triangle, with the perspective-correct weights of its second and
    // third corner.  False: nowhere before the eye.
    struct Meeting {
        double z;
        double weight_b, weight_c;
    };
    [[gnu::always_inline]] bool meets(double x, double y, Meeting& at) const {
        const glm::dvec3 values{value(0, x, y), value(1, x, y), value(2, x, y)};
        if (!inside(values, x, y)) return false;
        // Inside by the exact test, a value may still be rounded to just below 0; a sliver's three may all be
        // 0.
        const glm::dvec3 weights = glm::max(values, 0.0);
        const double sum = weights.x + weights.y + weights.z;
        const double inverse = sum > 0 ? 1 / sum : 0;
        const double z =
            (weights.x * vertices[0]->z + weights.y * vertices[1]->z + weights.z * vertices[2]->z) * inverse;
        at = {std::clamp(z, nearest, farthest), weights.y * inverse, weights.z * inverse};
        return true;
    }

    // False only if no pixel of `box` can be covered: all its corners are outside one edge.
    bool may_touch(const Raster& raster, const PixelBox& box) const {
        const double x[2] = {raster.centre_x(box.first_x), raster.centre_x(box.last_x)};
        const double y[2] = {raster.centre_y(box.first_y), raster.centre_y(box.last_y)};
        for (int edge = 0; edge < 3; ++edge) {
            const double most = std::max(std::max(value(edge, x[0], y[0]), value(edge, x[1], y[0])),
                                         std::max(value(edge, x[0], y[1]), value(edge, x[1], y[1])));
            if (most < -rounding[edge]) return false;
        }
        return true;
    }

  private:
    static double least(const glm::dvec3& v) { return std::min(std::min(v.x, v.y), v.z); }
    static double magnitude(const Raster& raster, const Ray& v) {
        return std::max(std::max(std::abs(v.x), std::abs(v.y)), raster.reach * std::abs(v.z));
    }
};

}  // namespace render
