// Any bytes as tables and a coded block: decoding fills the block and nothing else, or refuses.  Nothing
// else.
//
// An input is one byte of flags (1: colour, 2: a block of 4 KiB, 4: of triangles), the size of the tables
// (u16), tables, coded block.
#include <algorithm>
#include <span>
#include <vector>

#include "core/error.h"
#include "require.h"
#include "splat/coding/block_codec.h"
#include "splat/coding/run_codec.h"

namespace {

// Of blocks of nodes and of triangles.
struct Codecs {
    explicit Codecs(const splat::Header& header)
        : are_runs(header.has_triangles()), block_size(header.block_size), nodes(header), runs(header) {}
    bool decode(std::span<const std::byte> coded, const splat::DecodingTables& tables,
                std::span<std::byte> block) const {
        return are_runs ? runs.decode(coded, tables, block) : nodes.decode(0, coded, tables, block);
    }
    bool measure(std::span<const std::byte> coded, const splat::DecodingTables& tables,
                 std::span<double> bits) const {
        return are_runs ? runs.measure(coded, tables, block_size, bits) : nodes.measure(coded, tables, bits);
    }

    bool are_runs;
    uint32_t block_size;
    splat::BlockCodec nodes;
    splat::RunCodec runs;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size < 3) return 0;
    splat::Header header;
    if (data[0] & 1) header.flags = splat::kHasColour;
    if (data[0] & 4) header.flags |= splat::kTriangles, header.lattice_bits = 19;
    header.block_size = data[0] & 2 ? 4096 : 1024;
    header.block_count = 1;
    const size_t tables_size = std::min<size_t>(size_t(data[1]) | size_t(data[2]) << 8, size - 3);
    const auto bytes = std::as_bytes(std::span(data, size)).subspan(3);
    // Copies of the right size, so that reading past an end shows under a sanitizer.
    const std::vector<std::byte> tables(bytes.begin(), bytes.begin() + std::ptrdiff_t(tables_size));
    const std::vector<std::byte> coded(bytes.begin() + std::ptrdiff_t(tables_size), bytes.end());
    try {
        const splat::DecodingTables decoding(splat::decode_tables(
            tables, header.has_triangles() ? splat::kSymbolKinds : splat::kNodeSymbolKinds, "tables"));
        const Codecs codecs(header);
        std::vector<std::byte> block(header.block_size), again(header.block_size);
        std::vector<double> bits(splat::kSymbolFields.size());
        const bool is_sound = codecs.decode(coded, decoding, block);
        require(codecs.measure(coded, decoding, bits) == is_sound, "measuring refuses what decoding refuses");
        require(codecs.decode(coded, decoding, again) == is_sound && block == again,
                "decoding gives the same again");
    } catch (const core::Error&) {
        // rejecting tables is fine
    }
    return 0;
}
