// What the window wishes to see, and the pictures that are drawn of it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "geom/camera.h"
#include "render/frame.h"

namespace view {

// The magnifying glass: so many times as large, drawn anew and not blown up.
struct Lens {
    glm::dvec2 centre_px{0};  // of the picture
    int radius_px = 120;      // of the glass
    int magnification = 3;
};

struct Wish {
    geom::Camera camera;
    int width = 1, height = 1;
    render::Look look{};
    double threshold_px = 1;  // where the refinement of a view at rest ends
    double budget_ms = 33;    // time of a frame while the camera moves
    bool is_moving = false;
    std::optional<Lens> lens{};
};

// Whether a picture of the one is a picture of the other, however fine and whatever the lens.
bool show_the_same(const Wish& a, const Wish& b);
bool are_same(const std::optional<Lens>& a, const std::optional<Lens>& b);

// What is at a server of which something is on its way.
struct Arrival {
    uint64_t bytes_fetched = 0;
    uint64_t blocks_missing = 0;  // that the picture would show; 0 where the source has no blocks
    double part_there = 1;        // of what the picture needs; 0: not all, and nobody knows how much
};

struct PictureReport {
    double threshold_px = 0;
    double error_bound_px = 0;  // infinity where nothing is promised
    uint64_t splats = 0, triangles = 0;
    bool has_leaf_triangles = false;  // the triangles are the mesh itself, which nothing is finer than
    uint64_t bytes_touched = 0;
    double draw_ms = 0;
    // Of the way from coarse to the wished threshold, 0 to 1.
    double refinement = 1;
    // Nothing better will come but by a change of the wish.
    bool is_final = false;
    std::optional<Arrival> arrival{};
    std::string trouble{};  // one sentence where something is wrong that does not end the drawing
};

struct LensPicture {
    Lens lens;
    render::Frame frame;
};

struct Picture {
    uint64_t number = 0;  // from 1
    Wish wish;
    geom::View view;
    render::Frame frame;
    std::optional<LensPicture> lens;
    PictureReport report;

    // The depth of what is seen at a place of the picture, view z in world units; none where nothing is.
    std::optional<double> depth_at(const glm::dvec2& px) const;
};

// The part of a picture that a lens shows: a square in a view that is `magnification` times as large, moved
// inwards where it would reach over the picture's sides.
geom::View view_of(const Lens& lens, const geom::View& picture);

}  // namespace view
