// Vertices that are one in the input, where it was not manifold and was cut: which of those that are shown
// are drawn as one.
//
// They stand at one place, and a number tells apart what meets there by chance.  So a client knows it of
// vertices that have come, whatever they are called in the file.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace pm {

// Two vertices that are one in the input, where it was not manifold.
struct Weld {
    uint32_t copy, of;  // of < copy is not promised
};

// Numbers beyond are not told apart.
constexpr uint16_t kMostWeldNumber = 0xffff;

class WeldNumbers {
  public:
    WeldNumbers() = default;
    // `place` tells lattice coordinates, or the bits of single precision.  Welds may be in any order, form
    // chains and circles, or name vertices at two places, which are not one then.
    WeldNumbers(std::span<const Weld> welds, const std::function<glm::u32vec3(uint32_t)>& place);

    // 0: of no weld.  Of vertices at one place those with the same number are one.
    uint16_t operator[](uint32_t vertex) const;

  private:
    std::vector<std::pair<uint32_t, uint16_t>> numbers_;  // by vertex, rising
};

// A vertex that is shown, with a number that is not 0.
struct WeldedVertex {
    glm::u32vec3 place;
    uint16_t number;
    uint32_t vertex;
};

// as[v] of each of them becomes the lowest vertex that it is one with.
void join_welded(std::vector<WeldedVertex>& shown, std::span<uint32_t> as);

}  // namespace pm
