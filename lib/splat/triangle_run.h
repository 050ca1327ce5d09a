// Runs of triangle leaves: a table of corners, on the model's lattice, and which of them each triangle has.
//
// A run is a row of bits (man/qs.5, "Triangles"), lowest first: what it holds, then its triangles, positions,
// normals, and which triangles are smooth.  It is read from front to back: triangles are glued to earlier
// ones, corners are put beside those that their neighbours have, and normals told from the faces about them,
// so that little is left to say.  (Deering, Geometry compression, 1995, quantized vertices and a list of
// them, as the hybrid viewer's authors propose; corners that complete a parallelogram: Touma, Gotsman,
// Triangle mesh compression, 1998.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "splat/corner_normal.h"

namespace splat {

constexpr uint32_t kMostRunTriangles = 256;
constexpr size_t kRunSizeBytes = 2;   // a run begins with its size, these included
constexpr size_t kRunReadAhead = 24;  // bytes behind a run that are read, and may be anything

// Bits of a run's head, in this order.
constexpr uint32_t kRunSizeBits = 16, kRunTriangleBits = 8, kRunCornerBits = 10, kRunShadingBits = 2,
                   kPositionWidthBits = 5, kNormalWidthBits = 4;
enum class RunShading : uint32_t { flat, smooth, mixed };

// A corner's position, or its normal, is told from others and differs by so many bits a coordinate, by its
// class: positions width, width + 2, width + 4, or whatever there may be; normals none, width, width + 2, or
// likewise.
constexpr uint32_t kClassBits = 2, kClassStep = 2;
constexpr uint32_t kAnyNormalWidth = kCornerNormalBits + 1;
// (A corner and what is expected of it, a + b - c, are up to 4 * 2^lattice_bits apart.)
constexpr uint32_t any_position_width(uint32_t lattice_bits) {
    return lattice_bits + 4;
}
constexpr uint32_t position_width(uint32_t width, uint32_t size_class, uint32_t lattice_bits) {
    return size_class < 3 ? width + kClassStep * size_class : any_position_width(lattice_bits);
}
constexpr uint32_t normal_width(uint32_t width, uint32_t size_class) {
    return size_class == 0 ? 0 : size_class < 3 ? width + kClassStep * (size_class - 1) : kAnyNormalWidth;
}

// Where a corner is expected: at table entries a + b - c.
struct Parallelogram {
    uint32_t a = 0, b = 0, c = 0;
};

// A run that was read.
class TriangleRun {
  public:
    // Of the run that begins at `bytes`: its size says how many there are.
    static size_t size_of(std::span<const std::byte, kRunSizeBytes> bytes) {
        return size_t(bytes[0]) | size_t(bytes[1]) << 8;
    }

    // `bytes` is all of the run; kRunReadAhead more behind it are there to be read.  Returns a fault, or
    // nothing.
    std::string read(std::span<const std::byte> bytes, uint32_t lattice_bits);

    uint32_t triangles() const { return uint32_t(entries_.size()); }
    uint32_t corners() const { return corners_; }
    bool has_normals() const { return shading_ != RunShading::flat; }
    size_t size_bytes() const { return size_; }

    // Table entries of a triangle, all of them below corners().
    const glm::u32vec3& entries(uint32_t triangle) const { return entries_[triangle]; }
    // On the lattice, within it.  entry < corners().
    glm::i64vec3 position(uint32_t entry) const {
        return {positions_[0][entry], positions_[1][entry], positions_[2][entry]};
    }
    // Arrays of all corners, with room behind that may be read.
    static constexpr size_t kRoom = 64;
    const int32_t* positions(int axis) const { return positions_[axis].data(); }
    // Only with has_normals().
    uint32_t normal_code(uint32_t entry) const { return normals_[entry]; }
    const uint32_t* normal_codes() const { return normals_.data(); }
    bool is_smooth(uint32_t triangle) const {
        return shading_ == RunShading::smooth || (shading_ == RunShading::mixed && smooth_[triangle]);
    }

  private:
    class Bits;
    std::string read_triangles(Bits& bits);
    std::string read_positions(Bits& bits, uint32_t lattice_bits);
    std::string read_normals(Bits& bits);

    size_t size_ = 0;
    uint32_t corners_ = 0, position_width_ = 0, normal_width_ = 0;
    RunShading shading_ = RunShading::flat;
    std::vector<glm::u32vec3> entries_;
    std::vector<Parallelogram> expected_;  // by corner
    std::vector<int32_t> positions_[3];
    std::vector<uint32_t> normals_;
    std::vector<uint8_t> smooth_;
};

}  // namespace splat
