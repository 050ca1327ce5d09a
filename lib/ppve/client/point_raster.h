// Points on a raster: patches drawn as squares, a word a pixel with the depth above the colour, the least
// kept.
//
// Made for the many small squares of a point model.  Its splats have neither radius nor normal of their own;
// lib/render draws the same points in 1.4 to 1.6 times the time (point_view_bench --what splatter), and
// blends what here only the nearest of is to be seen.  The same words for any order of patches, number of
// threads and instruction set.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "ppve/depth_image.h"
#include "ppve/patch.h"

namespace ppve {

constexpr float kMostSplatPx = 64;  // no splat is larger

struct PointTask;  // a patch and a view, boiled down

// Where patches are seen from; lengths in tree units.
class PointView {
  public:
    // `frustum` has passed check(); `unit`: world units in a tree unit.
    PointView(const Frustum& frustum, double unit);

    int width() const { return width_; }
    int height() const { return height_; }

    // False only where nothing of the patch can reach into the raster, with splats of up to kMostSplatPx.
    bool may_see(const Patch& patch) const;
    // Rows of the raster, [first, end), outside which nothing of the patch is drawn, its splats being up to
    // `most_px` high.
    struct Rows {
        int first, end;
    };
    Rows rows_of(const Patch& patch, double most_px = double(kMostSplatPx)) const;
    // Pixels of the raster in which a sample of the patch stands for one of the view, at the middle of the
    // patch: equation (1) of the paper without its scale factor.  Infinity where that is not before the eye.
    float splat_px(const Patch& patch) const;
    // At least the same of every point of the patch.
    float most_splat_px(const Patch& patch) const;
    // The depth of a word of the raster, world units.
    double depth_of(uint64_t word) const {
        return (double(std::bit_cast<float>(static_cast<uint32_t>(word >> 32))) - depth_shift_) * unit_;
    }
    // What it is in a word, of world units.
    float depth_key(double depth) const { return static_cast<float>(depth / unit_ + depth_shift_); }

  private:
    friend class PointRaster;
    glm::vec3 at(const Patch& patch) const;  // its anchor in view space

    Projection projection_;
    int width_, height_;
    double unit_;
    glm::dvec3 eye_, right_, down_, forward_;
    float focal_, near_, far_;
    glm::vec2 principal_;
    double depth_shift_;      // added to depths, which are then positive
    glm::dvec3 sides_[4];     // planes of the frustum, inwards, through the eye
    double side_offsets_[4];  // what orthographic ones have beside
};

// How points with normals look: by octahedral_code(), 65536 entries, or empty.
struct PointShading {
    std::vector<uint32_t> factor;  // of the colour, in 2^-16, at most 1
    std::vector<uint32_t> colour;  // instead of the colour
};

struct PatchStyle {
    float scale = 1;           // of what splat_px() is at each point; the paper's scale factor
    float most_px = 1e30f;     // points with a splat larger than this (before the scale) are left out
    bool is_sized = true;      // false: one pixel each
    bool is_coloured = false;  // all points have the colour
    glm::u8vec3 colour{0};
};

// What points hold of a raster already, an entry a pixel.
struct Coverage {
    explicit Coverage(size_t pixels) : share(pixels), is_shown(pixels) {}

    std::vector<float> share;       // of the pixel that footprints overlap, squares about the points; summed
    std::vector<uint8_t> is_shown;  // 1 where a splat as large as its footprint, or a pixel, is drawn
};

class PointRaster {
  public:
    static constexpr uint64_t kEmpty = uint64_t(0x7f800000) << 32;  // depth: infinity

    // Empties rows [first, end) of a raster of the size; other rows are as they were.  Threads may share it,
    // with rows of their own, once resize() is done.
    void resize(int width, int height);
    void clear(int first, int end);

    // Draws a patch into rows [first, end), and says how many of its points fell there.  A splat covers the
    // pixels whose centres are in a square of splat_px() * scale about the point, at least one pixel.
    size_t draw(const PointView& view, const Patch& patch, const PatchStyle& style,
                const PointShading& shading, int first, int end);
    // The same of other points than the patch's own, from the same anchor; their footprints are
    // `coarseness` times as large.
    size_t draw(const PointView& view, const Patch& patch, const PatchPoints& points, float coarseness,
                const PatchStyle& style, const PointShading& shading, int first, int end);

    // Adds what a patch holds of pixels, of its points that are no larger than `most_px` pixels and where
    // their depth is at most the pixel's `limit`, as depth_key() has it, an entry a pixel.  Rows as in
    // draw().
    static void cover(const PointView& view, const Patch& patch, float most_px,
                      const std::vector<float>& limit, Coverage& coverage, int first, int end);

    int width() const { return width_; }
    int height() const { return height_; }
    // Depth in the upper half, as the bits of a float; colour in the lower.
    const uint64_t* row(int y) const { return words_.data() + size_t(y) * stride_; }

  private:
    static PointTask task_of(const PointView& view, const Patch& patch, const PatchPoints& points,
                             float coarseness, int first, int end);

    int width_ = 0, height_ = 0;
    size_t stride_ = 0;
    std::vector<uint64_t> words_;
};

}  // namespace ppve
