#include "splat/level_prefix.h"

#include <optional>

namespace splat {

namespace {

constexpr uint64_t kMargin = 4096;  // added to what is guessed, so that a guess is not short by a little

// To the end of a block that may not be there.
uint64_t bytes_to(const Model& model, uint64_t block) {
    const Header& header = model.header();
    if (model.has_block(block)) return model.prefix_bytes(block);
    const CodedFile* const coded = model.coded();
    if (!coded) return header.block_at(block + 1);
    const double mean = double(coded->file_size()) / double(header.block_count);
    return std::min(coded->file_size(),
                    std::max<uint64_t>(uint64_t(mean * double(block + 1)), model.size_bytes()) + kMargin);
}

struct Search {
    GroupAt begin;
    std::optional<uint64_t> lacking;  // a block that would tell, and is not there
};

// Where the level below begins: at the children of the first node that has some.
Search level_below(const Model& model, const GroupAt& level) {
    for (uint64_t block = level.block; block < model.header().node_blocks(); ++block) {
        if (!model.has_block(block)) return {{}, block};
        BlockView view;
        view.open(model, block);
        for (uint32_t slot = block == level.block ? level.slot : 0; slot < view.node_count(); ++slot)
            if (view.children_of(slot) > 0) return {view.group_of(slot), {}};
    }
    model.fault(level.block, "the header promises more levels");
}

}  // namespace

LevelPrefix level_prefix(const Model& prefix, uint32_t levels) {
    const Header& header = prefix.header();
    GroupAt level;
    if (levels >= header.level_count) level = {header.node_blocks(), 0};
    for (uint32_t i = 0; i < levels && levels < header.level_count; ++i) {
        const Search next = level_below(prefix, level);
        if (next.lacking) return {false, bytes_to(prefix, *next.lacking), *next.lacking + 1};
        if (next.begin.block < level.block ||
            (next.begin.block == level.block && next.begin.slot <= level.slot))
            prefix.fault(level.block, "its children do not stand behind it");
        level = next.begin;
    }
    const uint64_t last = level.slot > 0 ? level.block : level.block - 1;
    return {prefix.has_block(last) || !prefix.coded(), bytes_to(prefix, last), last + 1};
}

}  // namespace splat
