// The first stage of the exact rasteriser: a cluster's vertices on the raster, several at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ppve/sample/clusters.h"

namespace ppve {

// A frustum as vertices are brought into it: see RasterSampler.  All lengths times `scale`, a power of two.
struct RasterFrame {
    double offset[3];  // the mesh's origin
    double eye[3];
    double axes[3][3];  // right, down, forward
    double scale, focal_px;
    double corner_x, corner_y;  // the raster's upper left corner, from the principal point, pixels
    int width, height;
    double slack;  // pixels by which a place is rounded at most, generously
    bool perspective;
};

// No vertex has a place that is further from the principal point: edges of triangles that have one are told
// apart from pixel centres by exact arithmetic alone.
constexpr double kFarthestPlace = 65536;

// Pixels whose centres a vertex is at or left of, above, right of, below, give or take slack: 16 bits each of
// first column, first row, ~last column, ~last row.  The pixels of a triangle are the least of its corners'
// in each of the four.  kNowhere in the first: it is behind the eye, or beyond kFarthestPlace.
using PackedSpan = uint64_t;
constexpr int16_t kNowhere = -32768;

struct RasterVertices {
    alignas(64) double x[ClusterView::kMostVertices];  // place, pixels from the principal point
    alignas(64) double y[ClusterView::kMostVertices];
    alignas(64) double w[ClusterView::kMostVertices];  // 1 / depth; orthographic: depth
    alignas(64) PackedSpan span[ClusterView::kMostVertices];
};

void place_vertices(const RasterFrame& frame, const ClusterView& cluster, RasterVertices& out);

// Of triangles that may cover a pixel centre, the numbers, to `out` (room for all); returns how many.
size_t find_drawable(const ClusterView& cluster, const RasterVertices& vertices, uint16_t* out);

}  // namespace ppve
