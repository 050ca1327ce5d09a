// What of a path and of a picture is drawn: --frames and --tile.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/shots.h"

namespace qs_render {

// Every `step`-th frame from `begin` up to, not including, `end`.
struct FrameRange {
    size_t begin = 0, end = size_t(-1), step = 1;
};

// "A:B" or "A:B:STEP", where A and B may be left out.  Throws core::UsageError.
FrameRange parse_frames(const std::string& word);

// The numbers of those that a path of `count` frames has.  Throws core::UsageError where it has none.
std::vector<int> frame_numbers(const FrameRange& range, size_t count);

// "X,Y/NX,NY".  Throws core::UsageError.
scene::Tile parse_tile(const std::string& word);

}  // namespace qs_render
