// Writing the .pm file.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "core/file.h"
#include "pm/build/details.h"
#include "pm/format.h"

namespace pm {

// What vertices are, by number (Details::vertex is applied already).
struct VertexData {
    std::vector<glm::u32vec3> lattice;  // or
    std::vector<glm::vec3> single;      // of a lossless model
    std::vector<uint16_t> normals;      // or empty
    std::vector<glm::u8vec3> colours;   // or empty
};

// `header` has its counts, flags and placement; the hash is set.  Not committed.
void write_model(Header& header, const Details& details, const VertexData& vertices,
                 std::span<const Weld> welds, core::OutputFile& out);

}  // namespace pm
