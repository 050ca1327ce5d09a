// Any bytes as tables and a coded block: decoding fills the block and nothing else, or refuses.  Nothing
// else.
//
// An input is one byte of flags (1: colour, 2: a block of 4 KiB), the size of the tables (u16), tables, coded
// block.
#include <algorithm>
#include <span>
#include <vector>

#include "core/error.h"
#include "require.h"
#include "splat/block_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size < 3) return 0;
    splat::Header header;
    if (data[0] & 1) header.flags = splat::kHasColour;
    header.block_size = data[0] & 2 ? 4096 : 1024;
    header.block_count = 1;
    const size_t tables_size = std::min<size_t>(size_t(data[1]) | size_t(data[2]) << 8, size - 3);
    const auto bytes = std::as_bytes(std::span(data, size)).subspan(3);
    // Copies of the right size, so that reading past an end shows under a sanitizer.
    const std::vector<std::byte> tables(bytes.begin(), bytes.begin() + std::ptrdiff_t(tables_size));
    const std::vector<std::byte> coded(bytes.begin() + std::ptrdiff_t(tables_size), bytes.end());
    try {
        const splat::DecodingTables decoding(splat::decode_tables(tables, "tables"));
        const splat::BlockCodec codec(header);
        std::vector<std::byte> block(header.block_size), again(header.block_size);
        std::vector<double> bits(splat::kSymbolFields.size());
        const bool is_sound = codec.decode(0, coded, decoding, block);
        require(codec.measure(coded, decoding, bits) == is_sound, "measuring refuses what decoding refuses");
        require(codec.decode(0, coded, decoding, again) == is_sound && block == again,
                "decoding gives the same again");
    } catch (const core::Error&) {
        // rejecting tables is fine
    }
    return 0;
}
