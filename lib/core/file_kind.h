// What a file is by its first bytes, for messages about one that is not what was wanted.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace core {

enum class FileKind {
    unknown,
    splat_model,
    progressive_mesh,
    qsplat_model,  // of the original QSplat program
    ply,
    draco,
    las,  // and LAZ
    e57,
    volume,  // MetaImage
    png,
    jpeg,
    gltf,
};

// Of a file's first 16 bytes or more.  Kinds without a mark of their own (OBJ, STL, text) are unknown.
FileKind file_kind(std::span<const std::byte> beginning);

// "a PNG picture"; of an unknown kind, nothing.
std::string_view name_of(FileKind kind);

// The end of a sentence about a file with these bytes that is not of the form that was `wanted`, "a splat
// model", whose files begin with `mark`: "a PNG picture, not a splat model", "empty, not a splat model", "not
// a splat model (its first bytes are not 'qs-model')".
std::string is_not_wanted(std::span<const std::byte> bytes, std::string_view wanted, std::string_view mark);

}  // namespace core
