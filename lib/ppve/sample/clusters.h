// A mesh as it is kept to be sampled: clusters of triangles that lie together, each with its own vertices, in
// one array of bytes.  That array is also a file (ppve-clusters(5)), mapped: a frustum touches the table and
// the clusters that it meets, and nothing else is read.
//
// The order is that of a Morton curve through the triangles' middles.  Positions are the mesh's own, to the
// bit.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/file.h"
#include "mesh/mesh.h"
#include "ppve/sampler.h"

namespace ppve {

constexpr uint32_t kClusterTriangles = 512;  // -12% on the terrain's orbit against 1024, +3% against 256

// A cluster's bytes as they are used.  Vertices are padded to a multiple of kVertexPadding by copies of the
// last.
struct ClusterView {
    static constexpr uint32_t kVertexPadding = 8;
    static constexpr uint32_t kMostVertices = 3 * kClusterTriangles;

    uint32_t vertices = 0, triangles = 0;                  // vertices without padding
    const float *x = nullptr, *y = nullptr, *z = nullptr;  // from the mesh's origin
    const uint32_t* lit = nullptr;                         // 0x00BBGGRR under the scene's light
    const uint32_t* material = nullptr;                    // the surface's own
    const uint16_t* normal = nullptr;                      // octahedral_code()
    const uint16_t* corners = nullptr;                     // three a triangle, below `vertices`
};

class Clusters {
  public:
    // Of a mesh with triangles; a cloud's points become squares about their discs (radii and normals as they
    // are). Parallel.  Throws core::Error where there is nothing to sample.
    explicit Clusters(const mesh::Mesh& mesh);
    // Of a file that write() made.  Throws core::Error "<file>: ..." where the header or the table is
    // damaged.
    explicit Clusters(core::InputFile file);

    static bool is_file(std::span<const std::byte> bytes);
    void write(core::OutputFile& out) const;  // not committed

    // What is known of a cluster without touching it.
    struct Entry {
        float low[3], high[3];  // from the origin, rounded outward
        uint32_t vertices, triangles;
        uint64_t offset;
        uint64_t checksum;
    };
    std::span<const Entry> entries() const { return entries_; }
    const glm::dvec3& origin() const { return origin_; }
    Box bounds() const;
    uint64_t triangles() const { return triangles_; }
    uint64_t bytes() const { return bytes_.size(); }
    uint64_t bytes_of(size_t cluster) const;

    // Checks the cluster's bytes the first time.  Any thread.  Throws core::Error "<file>: cluster 7: ...".
    ClusterView view(size_t cluster) const;

  private:
    void read_header();
    void check(size_t cluster) const;
    ClusterView layout_of(size_t cluster) const;

    std::string name_;
    std::optional<core::InputFile> file_;
    std::vector<std::byte> own_;  // where there is no file
    std::span<const std::byte> bytes_;
    std::vector<Entry> entries_;
    glm::dvec3 origin_{0};
    uint64_t triangles_ = 0;
    std::unique_ptr<std::atomic<uint8_t>[]> is_checked_;
};

}  // namespace ppve
