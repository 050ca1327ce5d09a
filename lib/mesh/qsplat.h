// Models of the original QSplat program, file version 11: a hierarchy of bounding spheres with normals,
// normal cones and colours (Rusinkiewicz and Levoy, QSplat, 2000, section 3).
//
// All numbers are big-endian.  A file is one or more fragments, one behind the other:
//
//     "QSplat11"              8 bytes
//     length of the fragment  i32, bytes; the rest up to it, at most 3 bytes, is padding
//     leaves                  i32
//     options                 i32: 1 colour; 2 a comment, which is all that follows
//     root sphere             f32 centre x, y, z, radius
//     children of the root    i32
//     groups of siblings, breadth-first, the root's children first
//
//     group = [u32 pointer] then 2 to 4 nodes of 4 bytes, or 6 with colour
//     node  = u16: 13 bits sphere, 1 bit "a child has children", 2 bits children - 1 (0: a leaf)
//             u16: 14 bits normal, 2 bits cone
//             u16: colour, 5:6:5, red in the high bits
//
// The pointer is there where a node of the group has children: from the group's start to that of the first
// child group, behind which are those of its other nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "mesh/reader.h"

namespace mesh {

constexpr char kQsplatMagic[] = "QSplat11";
constexpr size_t kQsplatHeader = 40, kQsplatCommentHeader = 20, kQsplatPointer = 4;
constexpr int kQsplatFanOut = 4;
constexpr uint32_t kQsplatHasColour = 1, kQsplatIsComment = 2;  // options
// Bits of a node's first number.
constexpr uint32_t kQsplatChildren = 3, kQsplatGrandchildren = 4;
constexpr int kQsplatSphereShift = 3, kQsplatNormalShift = 2;
constexpr size_t qsplat_node_bytes(bool has_colour) {
    return has_colour ? 6 : 4;
}

// Bytes of a node's group of children.
constexpr size_t qsplat_group_bytes(uint32_t children, bool has_pointer, bool has_colour) {
    return (has_pointer ? kQsplatPointer : 0) + children * qsplat_node_bytes(has_colour);
}

struct QsplatSphere {
    glm::vec3 centre;
    float radius;
};

// The places and sizes that a child can have: a cube of `size` cells on a grid of 13 across the parent's box,
// at a multiple of cells, as long as it meets the parent's sphere.  The child is the sphere in the cube.
class QsplatSpheres {
  public:
    static constexpr int kCells = 13;
    static constexpr uint32_t kNoCode = 0xffff;

    static const QsplatSpheres& get();
    uint32_t count() const { return uint32_t(codes_.size()); }
    // In single precision, as the original does.
    QsplatSphere decode(uint32_t code, const QsplatSphere& parent) const {
        const QsplatSphere& c = codes_[code];
        return {parent.centre + parent.radius * c.centre, parent.radius * c.radius};
    }
    // Of the cube of `size` cells (1 to 13) from cell x, y, z on (0 to 13 - size).
    uint32_t code(int size, glm::ivec3 cell) const {
        return code_of_[size_t(((size - 1) * kCells + cell.x) * kCells + cell.y) * kCells + size_t(cell.z)];
    }

  private:
    QsplatSpheres();
    std::vector<QsplatSphere> codes_;  // in a unit sphere about 0
    std::vector<uint32_t> code_of_;
};

// Normals: the faces of a cube, 52 by 52 each.
constexpr uint32_t kQsplatNormalSteps = 52;
constexpr uint32_t kQsplatNormals = 6 * kQsplatNormalSteps * kQsplatNormalSteps;
// Unit length; zero for codes that no normal has (a face's outer rim lies outside the sphere).
glm::vec3 decode_qsplat_normal(uint32_t code);
// The nearest code; of zero some code.
uint32_t encode_qsplat_normal(const glm::vec3& normal);

// Sine of the cone's half-angle; 1: any direction.
constexpr float decode_qsplat_cone(uint32_t code) {
    return float((code + 1) * (code + 1)) / 16;
}

struct QsplatNode {
    QsplatSphere sphere;
    glm::vec3 normal;    // unit, or zero: unknown
    uint32_t cone;       // code
    glm::u8vec3 colour;  // with has_colour
    uint32_t children;   // 0, 2 to 4
    uint32_t level;      // 1 for the root's children
};

struct QsplatFragment {
    QsplatSphere root;
    uint64_t bytes = 0, nodes = 0, leaves = 0;
    uint64_t pointers = 0;
    bool has_colour = false;
};

// What a file holds beside its nodes.
struct QsplatFile {
    std::vector<QsplatFragment> fragments;
    std::vector<std::string> comments;  // lines of printable ASCII; what is not is '?'
};

bool is_qsplat(const Source& source);  // by the magic, whatever the version

// Reads all of a file and calls use(node) for each node, a fragment after the other, breadth-first.  Every
// length, pointer, count and code is checked.  Memory: less than 12 times the file.  Throws core::Error
// "<name>: fragment 2 at byte 1234: ...".
QsplatFile walk_qsplat(const Source& source, const std::function<void(const QsplatNode&)>& use);

// The leaves as a cloud with normals, radii and colours (white where only other fragments have them); with
// `level` the nodes of that level, from 1, and the leaves above it.  vertices_in counts leaves.
ReadResult read_qsplat(const Source& source, const ReadOptions& options, uint32_t level = ~uint32_t{0});

}  // namespace mesh
