// What a sampler is: something that makes depth images of one scene, whatever the scene is and however it
// does that.
//
// A pixel shows what the ray through its centre meets first between near and far: both sides of surfaces.
// Depths are rounded by the coding that is given, and of samples with the same code any may show, the same
// one each time, whatever the number of threads.  Colours are those of the surface under a light that is
// fixed to the scene, so that samples of different views agree; where normals are asked for, colours are the
// surface's own, for whoever lights them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>

#include "geom/sphere.h"
#include "ppve/depth_image.h"

namespace ppve {

// World units; low <= high, or all there is is empty (is_empty).
struct Box {
    glm::dvec3 low{0}, high{0};
    bool is_empty = true;

    void add(const glm::dvec3& point);
    geom::Sphere sphere() const;  // around it
    std::array<geom::Sphere, 8> corners()
        const;  // of no radius: the outline of what only its box is known of
};

// Depths between which a frustum may meet a box: within near and far, and positive for a perspective one.
// `is_empty`: nothing of it can be seen.
struct DepthRange {
    double nearest = 0, farthest = 0;
    bool is_empty = true;
};
DepthRange depths_in(const Frustum& frustum, const Box& box);

// What was done for one image.
struct SampleCounts {
    uint64_t bytes = 0, bytes_touched = 0;        // of the scene as it is kept: all, and those that were read
    uint64_t clusters = 0, clusters_touched = 0;  // the same in parts that are read or left out as one
    uint64_t clusters_hidden = 0;                 // of the frustum's, those left out because others hide them
    uint64_t triangles_tested = 0,
             triangles_drawn = 0;  // those in parts that were read, and with a pixel centre
    double ms = 0;
};

class Sampler {
  public:
    virtual ~Sampler() = default;

    // For the log and reports: "raster", "gl", "embree", "volume".
    virtual std::string name() const = 0;

    // All that can be seen lies in it.
    virtual Box bounds() const = 0;

    // Fills `image`, whose frustum (checked), coding and footprint are given; normals where `with_normals`.
    // One image at a time.  Throws core::Error where the scene's file is damaged or the device fails.
    virtual SampleCounts sample(DepthImage& image, bool with_normals) = 0;
};

// Sets an image up for a request: the coding that meets `bound_px`, or with 0 as fine as single-precision
// floats.
void prepare(const Sampler& sampler, double bound_px, DepthImage& image);

}  // namespace ppve
