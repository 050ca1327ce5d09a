// Building a progressive mesh: round, cut to a manifold, simplify to the floor, order by error, write.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/file.h"
#include "mesh/mesh.h"
#include "pm/format.h"

namespace pm {

struct BuildOptions {
    uint32_t bits = kDefaultBits;  // kMinBits..kMaxBits; 0: lossless
    bool flip_test = true;
    bool keep_colours = true;
    bool with_normals = false;  // the input's, or where it has none those of its faces
};

struct BuildReport {
    Header header;
    uint64_t file_bytes = 0;
    uint64_t unreferenced = 0, duplicate_faces = 0, cut_edges = 0, boundary_edges = 0;
    uint64_t zero_area_faces = 0;  // kept
    uint64_t flattened_faces = 0;  // of them, had an area before they were rounded
    double widest_gap = 0;         // extent of the widest boundary, in parts of the model's radius
    uint32_t passes = 0;
    uint64_t refused_links = 0, refused_flips = 0;
    uint64_t dependencies = 0;  // details that need another one which is no ancestor
    std::vector<std::pair<std::string, double>> stage_ms;
    std::vector<std::string> left_out;  // "colour: the input has none"
};

// Writes the model to `out` (not committed).  `mesh` is consumed.  `name` is for messages.  The same bytes
// whatever the number of threads.  Coordinates from 1e-38 to 1e38.  Throws core::Error: no faces, too many.
BuildReport build(mesh::Mesh&& mesh, const BuildOptions& options, core::OutputFile& out,
                  const std::string& name, const std::function<void(uint64_t)>& progress = {});

}  // namespace pm
