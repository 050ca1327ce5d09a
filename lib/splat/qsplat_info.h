// What a model of the original QSplat program holds: the counterpart of info.h for its files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/file.h"
#include "mesh/qsplat.h"

namespace splat {

struct QsplatLevel {
    uint64_t nodes = 0, leaves = 0;
    double radius_mean = 0, radius_max = 0;  // world units
};

struct QsplatInfo {
    std::string name;
    mesh::QsplatFile file;
    uint64_t file_bytes = 0;
    uint64_t nodes = 0, leaves = 0, pointers = 0;  // of all fragments
    bool has_colour = false;                       // some fragment has
    std::vector<QsplatLevel> levels;               // [0] are the roots
};

// Reads all of it.  Throws core::Error for a damaged file, as mesh::walk_qsplat() does.
QsplatInfo read_qsplat_info(const core::InputFile& file);

std::string to_text(const QsplatInfo& info);             // lines, for people
nlohmann::ordered_json to_json(const QsplatInfo& info);  // keys as in qs-info(1)

// Writes a level, from 1, and the leaves above it as points with normals and radii.  Returns how many. Throws
// core::Error: no such level, a damaged file.
uint64_t write_qsplat_cut(const core::InputFile& file, uint32_t level, core::OutputFile& out);

}  // namespace splat
