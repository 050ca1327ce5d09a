// Progressive meshes as they are drawn: what a view wants of a model in a file, or at a server, as triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geom/camera.h"
#include "geom/sphere.h"
#include "mesh/mesh.h"
#include "render/backend.h"

namespace scene {

// What it cost to have the mesh for a view.
struct ProgressiveCosts {
    uint64_t nodes_tested = 0, outside = 0, faces_away = 0;  // of a file
    uint32_t splits = 0;                                     // of the mesh
    uint64_t bytes_up = 0, bytes_down = 0;                   // of a server, since the frame before
    bool is_complete = true;                                 // all that the view wants is in the mesh
};

// One model.  Not thread-safe.
class ProgressiveSource {
  public:
    virtual ~ProgressiveSource() = default;
    virtual geom::Sphere bounds() const = 0;  // world units
    // Spheres that the surface fills: all vertices of a file; of a server what the base mesh tells.
    virtual std::vector<geom::Sphere> outline() const = 0;
    virtual bool has_colour() const = 0;
    // The mesh that the camera wants on a raster of width x height pixels, refined where the error is seen
    // larger than threshold_px.  Of a server: waits until all of it has come, or for `patience_s`, where what
    // has come by then is enough.
    virtual mesh::Mesh mesh_for(const geom::Camera& camera, int width, int height, double threshold_px,
                                ProgressiveCosts& costs, std::optional<double> patience_s = {}) = 0;
};

// A file with the bytes of a progressive mesh, or "pm://...": told by the name, or by the first bytes of the
// file.
// "-" is none.
bool is_progressive(const std::string& source);
// Throws core::Error, and core::UsageError for a location that is none.  `most_retries`: connections to a
// server that are lost in a row, or cannot be had again, before it is given up.
std::unique_ptr<ProgressiveSource> open_progressive(const std::string& source, int most_retries = 5);

// Draws a mesh by a back end, exactly, with normals of its own or of its faces; depths are in world units.
// Shade::level colours each triangle by its longest side in the picture, pixels, as splats are by their
// width.
void draw_mesh(const mesh::Mesh& mesh, const geom::View& view, const render::Look& look,
               render::SplatPainter& painter, render::Frame& frame);

}  // namespace scene
