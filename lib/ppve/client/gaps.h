// Gaps one pixel wide between splats, closed in the finished picture: so that splats need not be larger than
// their footprints to leave none, which makes every outline fatter.
//
// A pixel is a gap where two opposite ones of its eight neighbours both show something nearer, by more than a
// surface rises from pixel to pixel: a closing of the depth picture by segments of three pixels.  It gets the
// mean of the two, which for several pairs are the nearest ones.
#pragma once

#include <cstdint>
#include <vector>

#include "ppve/client/point_raster.h"

namespace ppve {

class GapCloser {
  public:
    // Of a perspective picture with pixels of 1 / focal_px.  `raster` is not changed while it is looked at.
    GapCloser(const PointRaster& raster, double focal_px);

    // The words of row y with its gaps closed, until the next call.  Rows in turn cost least.
    const uint64_t* row(int y);

  private:
    // Depths with an empty pixel more on each side.
    void load(int y, std::vector<float>& depths) const;
    uint64_t closed(int x, int y, float depth) const;

    const PointRaster& raster_;
    const float rise_;  // a gap's depth by its neighbours'
    int loaded_ = -2;   // the row that here_ has
    std::vector<float> above_, here_, below_;
    std::vector<float> nearest_;  // over the pairs, of the farther of the two
    std::vector<uint64_t> words_;
};

}  // namespace ppve
