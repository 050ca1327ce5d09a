// A triangle mesh or a cloud of bare points in memory, as flat arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/file.h"

namespace mesh {

struct Mesh {
    // World position of vertex v = origin + positions[v].  The origin is 0 for single-precision
    // input, whose coordinates are kept as they are; for double or integer input it is in the
    // middle of most points, so that map coordinates keep their detail.
    glm::dvec3 origin{0};
    std::vector<glm::vec3> positions;     // finite, all of them
    std::vector<glm::vec3> normals;       // empty, or one a vertex: unit length or zero (unknown)
    std::vector<glm::u8vec3> colours;     // empty, or one a vertex: sRGB bytes as in the file
    std::vector<float> radii;             // of a cloud: empty, or one a point: of the disc it stands for
    std::vector<glm::u32vec3> triangles;  // vertex indices, all in range; empty: bare points

    bool is_cloud() const { return triangles.empty(); }
    glm::dvec3 world(size_t v) const { return origin + glm::dvec3(positions[v]); }
};

// What the file held and what became of it: in = kept + dropped, by reason.
struct ReadCounts {
    uint64_t vertices_in = 0, faces_in = 0;  // as the file has them (polygons and strips: see triangles_in)
    uint64_t triangles_in = 0;               // after triangulation
    std::map<std::string, uint64_t> vertices_dropped;   // "not_finite", ...
    std::map<std::string, uint64_t> triangles_dropped;  // "not_finite_vertex", "repeated_index", ...
    std::string format;                                 // "ply binary_little_endian", "obj", ...
};

struct ReadOptions {
    bool skip_bad = false;  // drop vertices that are not finite (and their faces) instead of refusing
};

struct ReadResult {
    Mesh mesh;
    ReadCounts counts;
};

// Reads PLY (any form), OBJ, OFF, STL, Draco, or models of the original QSplat program (their leaves, as a
// cloud with normals and radii); the format is told by the content, then by the name.
// `path` "-" is standard input (told by content only: PLY, say).  Polygons are fanned, strips unrolled.
// Zero-area faces are kept; faces that name one vertex twice are dropped and counted. Memory: never more than
// a small multiple of the file's size, whatever its header claims. Throws core::Error "<file>: <place>: ...".
ReadResult read_mesh(const std::string& path, const ReadOptions& options = {});

// The same of a file that is open, and is closed as soon as it is read.
ReadResult read_mesh(core::InputFile file, const ReadOptions& options = {});

// The same of bytes in memory; `name` stands for the file's name, in messages and for its extension.
ReadResult read_mesh_bytes(std::span<const std::byte> bytes, const std::string& name,
                           const ReadOptions& options = {});

// Binary little-endian PLY of what the mesh holds (radii as `radius`; double coordinates where the origin is
// not 0).
std::string to_ply(const Mesh& mesh);

}  // namespace mesh
