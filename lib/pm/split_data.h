// One split, as packets tell it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace pm {

struct VertexData {
    glm::u32vec3 position{0};  // lattice coordinates, or the bits of single precision where it is lossless
    glm::u8vec3 colour{0};
    uint16_t normal = 0xffff;
    uint16_t weld = 0;  // welds.h: what it is one with at its place
};

struct ChildData {
    bool is_leaf = true;
    uint8_t error = 0, radius = 0;
};
// What is known of a node where bounds are not told (service.h): it may be split.
constexpr ChildData kUnknownNode{false, 0, 0};

// Cut vertices: positions in the canonical ring; -1: missing.
struct Cuts {
    int left = -1, right = -1;
};

struct SplitData {
    Cuts cuts;
    VertexData vertex;  // of the new child
    ChildData kept, fresh;
};

}  // namespace pm
