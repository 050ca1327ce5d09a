// The views of a frame: of the whole picture or of a tile of it, by one eye or by two.
#pragma once

#include <string>
#include <vector>

#include "geom/camera.h"
#include "render/frame.h"

namespace scene {

// One of across x down rectangles that a picture is cut into, counted from the upper left, from 0.  They
// differ by a pixel at most, each way, and are none of them empty: across and down are at most its width and
// height.
struct Tile {
    int x = 0, y = 0, across = 1, down = 1;
};

geom::View tile_of(const geom::View& picture, const Tile& tile);

// What a camera's frame is drawn on.
struct Screen {
    int width = 1280, height = 720;  // of the picture
    Tile tile{};
    bool is_stereo = false;
    // Of two eyes: the angle at the target between the lines to them.  The eyes look the same way, along
    // parallel axes, with frusta that meet in the plane of the target: what is there is at the same place in
    // both pictures, what is nearer comes out of the screen.
    double eye_angle_deg = 2;
};

struct EyeView {
    std::string eye;  // "left", "right"; empty where there is but one
    geom::View view;
};

// One view, or the left eye's and the right one's.  Throws as geom::make_view().
std::vector<EyeView> views_of(const geom::Camera& camera, const Screen& screen);

// Two frames of one height in one, which is resized.
void put_side_by_side(const render::Frame& left, const render::Frame& right, render::Frame& both);

}  // namespace scene
