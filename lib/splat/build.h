// Building a model from a mesh or a cloud: order the leaves, share out the faces, code upper tree and
// subtrees, lay out the blocks.  Parallel; the same bytes for any number of threads.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/file.h"
#include "mesh/mesh.h"
#include "splat/build/encode.h"
#include "splat/build/triangle_leaves.h"
#include "splat/format.h"
#include "splat/info.h"

namespace splat {

enum class Leaf { point, triangle };

struct BuildOptions {
    Leaf leaf = Leaf::point;
    uint32_t block_size = kMinBlockSize;  // power of two, kMinBlockSize..kMaxBlockSize
    uint64_t memory_limit = 0;            // bytes; 0: none.  More needed: refused with the figure
    bool keep_colour = true;
    bool compress = false;
};

struct BuildReport {
    Header header;
    uint64_t file_bytes = 0;
    std::vector<ChannelInfo> channels;
    uint64_t memory_needed = 0;                        // estimate, bytes
    std::map<std::string, uint64_t> vertices_dropped;  // "unreferenced"
    uint64_t zero_area_faces = 0;                      // kept for covering, not for normals
    uint64_t boundary_edges = 0;
    double widest_gap = 0;  // extent of the widest boundary, in parts of the model's radius
    FitCounts fit;
    TriangleCounts triangles;  // of triangle leaves
    std::vector<std::pair<std::string, double>> stage_ms;
    std::vector<std::string> left_out;  // "colour: the input has none"
};

// Writes the model to `out` (not committed).  `mesh` is consumed.  `name` is for messages.
// progress is told of leaves that are coded, from any thread.
// Throws core::Error: no vertices, memory limit, triangle leaves of bare points.
BuildReport build(mesh::Mesh&& mesh, const BuildOptions& options, core::OutputFile& out,
                  const std::string& name, const std::function<void(uint64_t)>& progress = {});

// Bytes that build() needs at its peak for so many vertices and triangles, the mesh itself included.
uint64_t memory_to_build(uint64_t vertices, uint64_t triangles, Leaf leaf, bool has_colour, bool has_normals);

}  // namespace splat
