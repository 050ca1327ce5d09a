// The faces about each vertex of a mesh that changes, built anew when it has.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace pm {

// A face about a vertex: corner 3f + k of face f is that vertex, then come `next` and `previous` in the
// face's sense.
struct Spoke {
    uint32_t next, previous, corner;
};

class Rings {
  public:
    // `vertices` and `faces` are those that are left; every corner is one of the vertices.
    void build(std::span<const glm::u32vec3> corners, std::span<const uint32_t> faces,
               std::span<const uint32_t> vertices, size_t vertex_count) {
        begin_.resize(vertex_count);
        count_.resize(vertex_count);
        // What a coarser mesh leaves over is given back, since what is kept of its collapses grows.
        if (3 * faces.size() < spokes_.capacity() / 4 * 3) spokes_ = std::vector<Spoke>();
        spokes_.resize(3 * faces.size());
        for (const uint32_t v : vertices) count_[v] = 0;
        for (const uint32_t f : faces)
            for (int k = 0; k < 3; ++k) ++count_[corners[f][k]];
        uint32_t at = 0;
        for (const uint32_t v : vertices) {
            begin_[v] = at;
            at += count_[v];
            count_[v] = 0;
        }
        for (const uint32_t f : faces) {
            const glm::u32vec3 face = corners[f];
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t v = face[int(k)];
                spokes_[begin_[v] + count_[v]++] = {face[int(k + 1) % 3], face[int(k + 2) % 3], 3 * f + k};
            }
        }
    }

    std::span<const Spoke> operator[](uint32_t vertex) const {
        return {spokes_.data() + begin_[vertex], count_[vertex]};
    }

    // Of a vertex that is not left.
    void clear(uint32_t vertex) { count_[vertex] = 0; }

    void release() { *this = Rings(); }

  private:
    std::vector<uint32_t> begin_, count_;
    std::vector<Spoke> spokes_;
};

}  // namespace pm
