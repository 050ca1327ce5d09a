// Writing models, block by block, from one that is there: compressed, or plain again.  Each way gives back
// the bytes that the other began with.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "core/file.h"
#include "splat/format.h"

namespace splat {

class CodedFile;
class Model;

// A plain model that can be read more than once.
struct PlainModel {
    Header header;
    std::array<std::byte, kHeaderSize> header_bytes;                        // as they stand in the file
    std::function<void(uint64_t number, std::span<std::byte> block)> read;  // from any thread; `block` is 0
};
PlainModel plain_of(const Model& model);  // which must outlive it, and be complete

// What a compressed model takes.
struct CompressedSizes {
    uint64_t file_bytes = 0;
    uint64_t table_bytes = 0, index_bytes = 0;
    uint64_t blocks_as_they_are = 0;  // what their coding would not have made smaller
    uint64_t block_size = 0;
    std::vector<double> field_bits;  // in coded blocks, as kSymbolFields; with bits that are as they are
};

// Writes the model compressed.  Reads it three times over: to count symbols, to size
// the blocks, and to write them; memory: the blocks of eight index pages, and 8 bytes for every 256 blocks.
CompressedSizes write_compressed(const PlainModel& model, core::OutputFile& out);

uint64_t write_plain(const PlainModel& model, core::OutputFile& out);  // returns the bytes written

CompressedSizes sizes_of(const CodedFile& file);  // decodes all of its blocks, which must be there

}  // namespace splat
