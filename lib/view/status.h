// What the window says in words.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "view/picture.h"

namespace view {

struct Rates {
    double pictures_per_s = 0;
    double bytes_per_s = 0;  // of the network
};

// "31 frames/s   412 k splats   threshold 2.8 px   error below 1.9 px   3.1 MB   12 blocks missing   1.2
// MB/s": what there is of it.
std::string status_line(const PictureReport& report, const Rates& rates);

// What a picture by resolution means: the colour of what is drawn so wide on the screen, a splat, a point, or
// the longest side of a triangle.  Triangles that are the mesh itself have the colour of the finest splats.
struct LegendEntry {
    glm::u8vec3 colour;
    std::string text;  // "2 to 4 px"
};
std::vector<LegendEntry> legend(const PictureReport& report);

// What a key or the mouse does, as F1 shows it and qs-view(1) has it.
struct KeyHelp {
    const char* keys;
    const char* meaning;
};
std::vector<KeyHelp> key_help();

}  // namespace view
