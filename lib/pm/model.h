// A progressive mesh that is being read: a mapped file, checked once when it is opened.
//
// After that every number in it is in its range: details depend on earlier details only, vertices and faces
// are there.  Opening reads all but the positions, at some gigabytes a second.  Threads may share a model.
#pragma once

#include <bit>
#include <glm/glm.hpp>
#include <span>
#include <string>

#include "core/file.h"
#include "pm/bounds.h"
#include "pm/format.h"
#include "pm/welds.h"

namespace pm {

// Leaf corners of the faces that a split adds, or kNone thrice where it is at a boundary and adds one only.
// The left one is (new, kept, cut), the right one (kept, new, cut), in the surface's sense: a leaf below the
// new child, one below the kept child, and the fundamental cut vertex.
struct SplitFaces {
    glm::u32vec3 left, right;

    uint32_t left_cut() const { return left.z; }
    uint32_t right_cut() const { return right.z; }
};

// The details that split the two children of a split, or kNone.
struct Children {
    uint32_t kept, fresh;
};

// The hierarchy in arrays by detail, as a file has it or as a client has received it.  The format says what
// they mean.
struct Hierarchy {
    uint32_t base_vertices = 0;
    std::span<const glm::u32vec3> base_faces;
    std::span<const uint32_t> kept, parent, needs;
    std::span<const SplitFaces> faces;

    uint32_t details() const { return uint32_t(kept.size()); }
    uint32_t vertices() const { return base_vertices + details(); }
    uint32_t born_by(uint32_t detail) const { return base_vertices + detail; }
};

class Model {
  public:
    // Throws core::Error: not a model, damaged header, cut off, numbers out of range.  A file's bytes are
    // compared with their hash by verify() only.
    explicit Model(const std::string& path);
    explicit Model(core::InputFile file);

    const std::string& name() const { return file_.name(); }
    const Header& header() const { return header_; }
    uint64_t hash() const { return model_hash(header_); }  // tells models apart
    uint64_t size_bytes() const { return layout_.end; }
    uint32_t details() const { return header_.details; }
    uint32_t vertices() const { return header_.base_vertices + header_.details; }

    std::span<const std::byte> content() const { return file_.bytes().subspan(kHeaderSize); }
    bool is_padding_zero() const;  // of what fills sections up

    Hierarchy hierarchy() const;
    std::span<const uint32_t> root_split() const;  // by base vertex
    std::span<const Children> children() const;    // by detail
    std::span<const Weld> welds() const;

    // Of the node that a detail splits.
    NodeBounds bounds(uint32_t detail) const;
    uint8_t error_code(uint32_t detail) const { return uint8_t(at(layout_.error)[detail]); }
    uint8_t radius_code(uint32_t detail) const { return uint8_t(at(layout_.radius)[detail]); }
    ConeCodes cone(uint32_t detail) const;

    // Of a vertex.  Lattice coordinates are 0 .. 2^bits - 1; not of a lossless model.
    glm::u32vec3 lattice(uint32_t vertex) const;
    glm::vec3 single(uint32_t vertex) const;  // of a lossless model: relative to placement.origin
    glm::dvec3 unit(uint32_t vertex) const;
    glm::dvec3 world(uint32_t vertex) const;
    glm::u8vec3 colour(uint32_t vertex) const;
    uint16_t normal_code(uint32_t vertex) const;
    uint16_t weld_number(uint32_t vertex) const { return weld_numbers_[vertex]; }  // welds.h
    // The lattice coordinates, or the bits of single precision.
    glm::u32vec3 exact_position(uint32_t vertex) const;

  private:
    const std::byte* at(uint64_t offset) const { return file_.bytes().data() + offset; }
    template <class T>
    std::span<const T> section(uint64_t offset, uint64_t count) const;
    void check_contents() const;

    core::InputFile file_;
    Header header_;
    Layout layout_;
    WeldNumbers weld_numbers_;
};

// Unit space from what a file or a packet holds, the same bits on both sides.
inline glm::dvec3 unit_from_lattice(const glm::u32vec3& lattice, const Header& header) {
    return glm::dvec3(lattice) / header.steps();
}
glm::dvec3 unit_from_single(const glm::vec3& position, const Header& header);
// Of either, as Model::exact_position() has it.
inline glm::dvec3 unit_from_exact(const glm::u32vec3& position, const Header& header) {
    if (!header.is_lossless()) return unit_from_lattice(position, header);
    return unit_from_single({std::bit_cast<float>(position.x), std::bit_cast<float>(position.y),
                             std::bit_cast<float>(position.z)},
                            header);
}

}  // namespace pm
