// How wrong a frame is: measured against the mesh that it stands for.
#pragma once

#include <memory>

#include "geom/camera.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "render/compare.h"
#include "render/frame.h"
#include "render/raster.h"

namespace scene {

struct ReferenceMeasures {
    render::ImageDifference difference;  // of the frame against the mesh drawn for the same view
    double measured_error_px = 0;        // from the mesh, see below
};

// The largest over all covered pixels of d * focal_px / z: d is the distance in space, from the surface, of
// the point that the pixel shows (on the ray through where its depth z is taken, at that depth).  0 where
// nothing is covered, infinity where a pixel's point is not finite.  This is what CutCounts::error_bound_px
// bounds. Parallel, the same for any number of threads.
double measured_error_px(const mesh::SurfaceDistance& surface, const geom::View& view,
                         const render::Frame& frame);

// How much a measured error may be above its bound by rounding (frame-report(5)): of the picture's points,
// and of depths, which are in single precision.
double rounding_px(const geom::View& view);

// A mesh to hold frames against.  Keeps the mesh, its rasteriser's buffers and a tree of boxes: some 130
// bytes a triangle.
class Reference {
  public:
    // `name` is for messages.  `with_colour`: drawn in the mesh's colours where it has any, else in grey
    // (for a model without colour).  Throws core::Error for a mesh without triangles.
    Reference(mesh::Mesh mesh, const std::string& name, bool with_colour);

    // Draws the mesh as the frame was drawn and measures; parallel, the same for any number of threads.
    // `frame` is of the view's size.  About a microsecond for each covered pixel and thread.
    ReferenceMeasures measure(const geom::View& view, const render::Look& look, const render::Frame& frame);

    const render::Frame& frame() const { return frame_; }  // of the last measure()
    bool has_colour() const { return !mesh_.colours.empty(); }

  private:
    mesh::Mesh mesh_;
    mesh::SurfaceDistance distance_;
    render::MeshRaster raster_;
    render::Frame frame_;
};

// The point that a pixel of a frame shows, world units; not finite where the pixel is not covered.
glm::dvec3 point_of_pixel(const geom::View& view, const render::Frame& frame, int x, int y);

}  // namespace scene
