// What a progressive mesh holds.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pm/model.h"

namespace pm {

// Of one step of the errors' lattice that has details: how many there are up to and with it, in the file's
// order.
struct ErrorLevel {
    double error = 0;  // world units
    uint64_t splits = 0, faces = 0;
};

struct Info {
    std::string name;
    Header header;
    uint64_t file_bytes = 0;
    uint64_t dependencies = 0;     // details that need another one which is no ancestor
    uint64_t boundary_splits = 0;  // that add one face
    uint64_t without_cone = 0;
    std::vector<ErrorLevel> levels;
    std::vector<std::pair<std::string, uint64_t>> sections;  // their bytes; they add up to file_bytes

    // Bits that would name a tree, and a node in it by its path from the root, as in the paper's table 1.
    uint32_t tree_bits() const;
    uint32_t node_bits() const { return header.depth + 1; }
};

Info read_info(const Model& model);

std::string to_text(const Info& info);             // lines, for people
nlohmann::ordered_json to_json(const Info& info);  // keys as in qs-info(1)

}  // namespace pm
