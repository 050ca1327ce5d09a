// The header of a PLY file: which elements follow, in what form.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/reader.h"

namespace mesh {

enum class PlyForm { ascii, little_endian, big_endian };
enum class PlyType : uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

size_t size_of(PlyType type);  // bytes in a binary file
bool is_float(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    bool is_list = false;
    PlyType count_type = PlyType::uint8;  // of a list: an integer type
};

struct PlyElement {
    std::string name;
    uint64_t count = 0;  // as claimed: to be checked against the bytes that follow
    std::vector<PlyProperty> properties;

    bool has_list() const;
    // Bytes of one record in a binary file; with lists, of one whose lists are empty.
    uint64_t smallest_record_bytes() const;
};

struct PlyHeader {
    PlyForm form = PlyForm::ascii;
    std::vector<PlyElement> elements;
    size_t body = 0;  // byte where the first element begins

    const char* form_name() const;  // as the file has it, "binary_little_endian"
};

// Throws Error "file: line N: ...".
PlyHeader read_ply_header(const Source& source);

}  // namespace mesh
