// A finished frame and how a surface point is shaded.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace render {

// Row 0 on top, rows without padding.  A pixel is covered where depth is finite.
struct Frame {
    int width = 0, height = 0;
    std::vector<uint8_t> rgb;  // 3 bytes a pixel
    std::vector<float> depth;  // along the line of sight (view z), world units; infinity: background

    void resize(int w, int h) {
        width = w, height = h;
        rgb.assign(size_t(3) * size_t(w) * size_t(h), 0);
        depth.assign(size_t(w) * size_t(h), std::numeric_limits<float>::infinity());
    }
};

// lit: material * (0.05 + 0.95 * max(0, n.l)), head light (l towards the eye along the view axis:
// (0, 0, -1) in view space), material 0.9 grey or the surface's colour, rounded to the nearest byte;
// a normal that faces away gets 0.05.  normal: (n.x, -n.y, -n.z) mapped from -1..1 to 0..255, so that
// right is red, up is green and a surface facing the eye is (128, 128, 255).  level: lit, the
// material being a colour for the projected size of what was drawn (level_colour in shading.h).
// flat: material, unlit.
enum class Shade { lit, normal, level, flat };

// square, circle: screen-aligned, sampled at pixel centres, constant depth (as the original's).
// ellipse: the flat ellipsoid's exact outline, depth plus a hill.  smooth: blended.
enum class SplatKind { square, circle, ellipse, smooth };

}  // namespace render
