// A finished frame, and how what is drawn in it looks.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace render {

// Row 0 on top, rows without padding.  A pixel is covered where depth is finite.
struct Frame {
    int width = 0, height = 0;
    std::vector<uint8_t> rgb;    // 3 bytes a pixel
    std::vector<uint8_t> alpha;  // a byte a pixel, by which rgb is not multiplied; empty: all opaque
    std::vector<float> depth;    // along the line of sight (view z), world units; infinity: background
    double depth_at = 0.5;       // where in its pixel, from the left and from the top, the depth is taken

    void resize(int w, int h) {
        width = w, height = h;
        rgb.assign(size_t(3) * size_t(w) * size_t(h), 0);
        alpha.clear();
        depth_at = 0.5;
        depth.assign(size_t(w) * size_t(h), std::numeric_limits<float>::infinity());
    }
};

// lit: material * (0.05 + 0.95 * max(0, n.l)), head light (l towards the eye along the view axis:
// (0, 0, -1) in view space), material 0.9 grey or the surface's colour, rounded to the nearest byte;
// a normal that faces away gets 0.05.  With a key light: as Light in shading.h has it.  normal: (n.x, -n.y,
// -n.z) mapped from -1..1 to 0..255, so that right is red, up is green and a surface facing the eye is (128,
// 128, 255).  level: lit, the material being a colour for the projected size of what was drawn (level_colour
// in shading.h). flat: material, unlit.
enum class Shade { lit, normal, level, flat };

// How what is drawn looks, whoever draws it.
struct Look {
    Shade shade = Shade::lit;
    glm::u8vec3 background{0, 0, 0};
    uint8_t background_alpha = 255;  // below 255 frames have an alpha
    // A pixel is the mean of so many by so many samples, at the centres of its equal squares: 1, 2 or 4.  The
    // bytes are averaged as they would be stored, so that a picture of 2 x 2 samples is the one of twice the
    // size scaled down.  The depth is that of one of the samples (Frame::depth_at): a mean of depths of two
    // surfaces is on neither.
    int samples_across = 1;
    std::optional<glm::dvec3> key_light{};  // the direction it comes from, world space, of any length but 0

    bool has_alpha() const { return background_alpha < 255; }
    // Which sample has the depth, from the left and from the top, and where it is.
    int depth_sample() const { return samples_across / 2; }
    double depth_at() const { return (depth_sample() + 0.5) / samples_across; }
};

// square, circle: screen-aligned, sampled at pixel centres, constant depth (as the original's).
// ellipse: the flat ellipsoid's exact outline, depth plus a hill.  smooth: blended.
enum class SplatKind { square, circle, ellipse, smooth };

}  // namespace render
