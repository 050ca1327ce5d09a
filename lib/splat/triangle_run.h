// Runs of triangle leaves: a table of corners, on the model's lattice, and which of them each triangle has.
//
// A run is a row of bits (man/qs.5, "Triangles"), lowest first:
//
//     7 triangles - 1, 9 corners - 1, 3 x 5 widths of positions, 1 has_normals
//     3 x (lattice_bits + 1) base + 2^lattice_bits
//     with has_normals: 2 x 4 widths of normals, 2 x 12 base
//     corners x (x, y, z above the base, of their widths)
//     corners x (column, row above their base), with has_normals
//     triangles x 3 x (1: the table's next entry; or 0 and one that was used before, as wide as corners - 1
//     takes) triangles x 1 smooth, with has_normals
//
// Neighbours share corners: a run of 128 has 0.8 corners a triangle, a table for each sibling group would
// have 1.2. (An index to a list of quantized vertices: Deering, Geometry compression, 1995, as the hybrid
// viewer's authors propose.)
#pragma once

#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace splat {

constexpr uint32_t kMostRunTriangles = 128;
constexpr size_t kRunsAt = 8;  // of a block of triangles

// A corner's normal: octahedral, 4095 x 4095, column and row << 12; what has no direction is code 0.
constexpr int kCornerNormalSteps = 4095;
constexpr uint32_t kCornerNormalBits = 12;  // a column, or a row
uint32_t encode_corner_normal(const glm::dvec3& unit);
glm::vec3 decode_corner_normal(uint32_t code);

// A run in a block, which lives longer.
class TriangleRun {
  public:
    TriangleRun() = default;
    // Reads the run at `offset` of a block's used bytes.  Returns a fault, or nothing.
    std::string open(std::span<const std::byte> used, size_t offset, uint32_t lattice_bits);

    uint32_t triangles() const { return triangles_; }
    uint32_t corners() const { return corners_; }
    bool has_normals() const { return has_normals_; }
    size_t size_bytes() const { return (end_ + 7) / 8; }
    bool has_zero_padding() const;

    // On the lattice.  entry < corners().
    glm::i64vec3 position(uint32_t entry) const;
    uint32_t normal_code(uint32_t entry) const;  // 0 without has_normals()
    // Of all triangles their corners' entries, all of them below corners().  Returns a fault, or nothing.
    std::string read_entries(std::vector<glm::u32vec3>& entries) const;
    bool is_smooth(uint32_t triangle) const { return has_normals_ && bits(end_ - triangles_ + triangle, 1); }

  private:
    uint32_t bits(size_t at, uint32_t count) const;  // count <= 32

    std::span<const std::byte> bytes_;
    uint32_t triangles_ = 0, corners_ = 0, width_[3] = {}, normal_width_[2] = {}, position_width_ = 0;
    bool has_normals_ = false;
    glm::i64vec3 base_{0};
    uint32_t normal_base_[2] = {};
    size_t positions_at_ = 0, normals_at_ = 0, entries_at_ = 0, end_ = 0;  // bits
};

// Puts triangles into a run as long as there is room.
class RunPacker {
  public:
    explicit RunPacker(uint32_t lattice_bits) : lattice_bits_(lattice_bits) {}

    struct Corner {
        uint32_t vertex;  // corners of one vertex share an entry
        glm::ivec3 position;
        uint32_t normal;
    };
    // False, and nothing is added, where the run would take more than `room` bytes.
    bool add(const Corner (&corners)[3], bool is_smooth, size_t room);
    bool is_empty() const { return triangles_.empty(); }
    bool is_full() const { return triangles_.size() == kMostRunTriangles; }

    // Appends the run's bytes and begins anew.
    void finish(std::vector<std::byte>& out);

  private:
    // What the size of a run depends on.
    struct Extent {
        size_t triangles = 0, corners = 0;
        glm::ivec3 low{0}, high{0};
        glm::uvec2 normal_low{~0u}, normal_high{0};  // of corners of smooth triangles
        bool has_normals = false;
    };
    size_t size_bits(const Extent& e) const;

    const uint32_t lattice_bits_;
    std::vector<Corner> table_;
    std::vector<uint8_t> needs_normal_;  // by entry: a smooth triangle has it
    std::vector<glm::u32vec3> triangles_;
    std::vector<uint8_t> smooth_;
    Extent extent_;
};

}  // namespace splat
