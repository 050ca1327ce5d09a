#include "splat/compress.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "splat/coding/block_codec.h"
#include "splat/coding/block_index.h"
#include "splat/coding/coded_file.h"
#include "splat/coding/run_codec.h"
#include "splat/model.h"

namespace splat {

namespace {

constexpr uint64_t kBatchBlocks = 8 * kPageEntries;  // held in memory

using Groups = std::vector<uint8_t>;

// The sizes of a model's sibling groups in the order of the file: the numbers of children, where there are
// any, from the root's on.  Needs no tree, only the blocks one after the other.  Where they hold something
// else than nodes this means nothing, and does no harm.
class GroupSizes {
  public:
    explicit GroupSizes(const PlainModel& model)
        : model_(model),
          layout_(model.header),
          block_(model.header.block_size),
          next_(model.header.root_children) {}

    // The groups of the next block, of `node_count` nodes; of fewer where no more are known.
    Groups take(uint32_t node_count) {
        Groups groups;
        for (uint32_t sum = next_; next_ > 0 && sum <= node_count; sum += next_) {
            groups.push_back(uint8_t(next_));
            next_ = size_of_next_group();
        }
        return groups;
    }

  private:
    uint32_t size_of_next_group() {
        while (true) {
            for (; slot_ < node_count_; ++slot_) {
                uint16_t attitude;
                std::memcpy(&attitude, block_.data() + layout_.attitude + 2 * size_t(slot_),
                            sizeof(attitude));
                if ((attitude & 7) != 0) return ++slot_, attitude & 7u;
            }
            if (next_block_ == model_.header.block_count) return 0;
            std::fill(block_.begin(), block_.end(), std::byte{0});
            model_.read(next_block_++, block_);
            uint16_t count;
            std::memcpy(&count, block_.data() + offsetof(BlockHeader, node_count), sizeof(count));
            node_count_ = std::min<uint32_t>(count, layout_.capacity), slot_ = 0;
        }
    }

    const PlainModel& model_;
    const BlockLayout layout_;
    std::vector<std::byte> block_;  // the one that the next groups' parents are in
    uint64_t next_block_ = 0;
    uint32_t node_count_ = 0, slot_ = 0;
    uint32_t next_;
};

// Where in their runs the blocks of triangles begin, from the first one on: needs no nodes either.
class RunPlaces {
  public:
    explicit RunPlaces(const PlainModel& model)
        : model_(model),
          codec_(model.header),
          next_(model.header.node_blocks()),
          block_(model.header.block_size) {
        if (next_ < model_.header.block_count) model_.read(next_, block_);
    }

    // Of the next block.
    RunPlace take() {
        const RunPlace place = place_;
        std::vector<std::byte> behind(++next_ < model_.header.block_count ? block_.size() : 0);
        if (!behind.empty()) model_.read(next_, behind);
        place_ = codec_.end_of({block_, place}, behind);
        block_ = std::move(behind);
        return place;
    }

  private:
    const PlainModel& model_;
    const RunCodec codec_;
    uint64_t next_;
    std::vector<std::byte> block_;
    RunPlace place_;
};

// What coding blocks needs to know of those before them, in the order of the file.
struct Before {
    explicit Before(const PlainModel& model) : sizes(model), places(model) {}
    GroupSizes sizes;
    RunPlaces places;
};

// Blocks in a row.
class Batch {
  public:
    Batch(const PlainModel& model, uint64_t first, Before& before)
        : block_size_(model.header.block_size),
          first_(first),
          node_blocks_(model.header.node_blocks()),
          groups_(std::min(kBatchBlocks, model.header.block_count - first)),
          places_(groups_.size()),
          bytes_(groups_.size() * block_size_) {
        core::parallel_for(
            count(), [&](size_t i) { model.read(first + i, span_of(i)); }, 16);
        for (size_t i = 0; i < count(); ++i) {
            if (are_runs(i)) {
                places_[i] = before.places.take();
                continue;
            }
            uint16_t nodes;
            std::memcpy(&nodes, span_of(i).data() + offsetof(BlockHeader, node_count), sizeof(nodes));
            groups_[i] = before.sizes.take(nodes);
        }
    }
    size_t count() const { return groups_.size(); }
    bool are_runs(size_t i) const { return first_ + i >= node_blocks_; }
    PlainBlock nodes(size_t i) { return {first_ + i, span_of(i), groups_[i]}; }
    PlainRuns runs(size_t i) { return {span_of(i), places_[i]}; }

  private:
    std::span<std::byte> span_of(size_t i) { return std::span(bytes_).subspan(i * block_size_, block_size_); }

    size_t block_size_;
    uint64_t first_, node_blocks_;
    std::vector<Groups> groups_;    // of blocks of nodes
    std::vector<RunPlace> places_;  // of blocks of triangles
    std::vector<std::byte> bytes_;
};

class Compressor {
  public:
    explicit Compressor(const PlainModel& model)
        : model_(model),
          codec_(model.header),
          run_codec_(model.header),
          index_(model.header.block_count),
          version_(model.header.has_triangles() ? 2 : 1) {}

    CompressedSizes write(core::OutputFile& out) {
        train();
        size_runs();
        sizes_.file_bytes = header_of(0).size() + size_of_index(index_.levels() - 1, 0);
        sizes_.table_bytes = tables_bytes_.size();
        sizes_.index_bytes = index_.total_bytes();
        sizes_.block_size = model_.header.block_size;
        out.write(encode_coded_header(header_of(sizes_.file_bytes)));
        for_each_batch([&](uint64_t first, Batch& batch) { write_batch(first, encode(batch), out); });
        return sizes_;
    }

  private:
    CodedHeader header_of(uint64_t file_size) const {
        return {version_, file_size, model_.header_bytes, tables_bytes_};
    }

    template <class Use>
    void for_each_batch(const Use& use) const {
        Before before(model_);
        for (uint64_t first = 0; first < model_.header.block_count; first += kBatchBlocks) {
            Batch batch(model_, first, before);
            use(first, batch);
        }
    }

    // Counts are sums, so that they do not depend on who counts first.
    void train() {
        SymbolCounts counts = no_symbols();
        for_each_batch([&](uint64_t, Batch& batch) {
            constexpr size_t kPiece = kPageEntries;
            std::vector<SymbolCounts> pieces((batch.count() + kPiece - 1) / kPiece);
            core::parallel_pieces(batch.count(), kPiece, [&](size_t begin, size_t end) {
                SymbolCounts& piece = pieces[begin / kPiece] = no_symbols();
                for (size_t i = begin; i < end; ++i) count(batch, i, piece);
            });
            for (const SymbolCounts& piece : pieces)
                std::transform(piece.begin(), piece.end(), counts.begin(), counts.begin(), std::plus());
        });
        const uint32_t kinds = header_of(0).symbol_kinds();
        tables_bytes_ = encode_tables(counts, kinds);
        shares_ = decode_tables(tables_bytes_, kinds, "");
        encoding_.emplace(shares_);
        decoding_.emplace(shares_);
        sizes_.field_bits = bits_of(counts, shares_);
    }

    void count(Batch& batch, size_t i, SymbolCounts& counts) const {
        if (batch.are_runs(i)) {
            if (run_codec_.can_code(batch.runs(i))) run_codec_.count(batch.runs(i), counts);
        } else if (codec_.can_code(batch.nodes(i))) {
            codec_.count(batch.nodes(i), counts);
        }
    }

    void size_runs() {
        for_each_batch([&](uint64_t first, Batch& batch) {
            const auto coded = encode(batch);
            for (size_t i = 0; i < coded.size(); i += kPageEntries) {
                uint64_t size = index_.page_bytes(0, (first + i) / kPageEntries);
                for (size_t k = i; k < std::min(coded.size(), i + kPageEntries); ++k) {
                    size += coded[k].size();
                    sizes_.blocks_as_they_are += coded[k].size() == model_.header.block_size;
                }
                run_sizes_.push_back(size);
            }
        });
    }

    // Of a page and all that it lists.
    uint64_t size_of_index(uint32_t level, uint64_t page) const {
        if (level == 0) return run_sizes_[page];
        const auto listed = sizes_of(level, page);
        return std::accumulate(listed.begin(), listed.end(), index_.page_bytes(level, page));
    }
    std::vector<uint64_t> sizes_of(uint32_t level, uint64_t page) const {  // level 1 or higher
        std::vector<uint64_t> sizes(index_.entries(level, page));
        for (size_t e = 0; e < sizes.size(); ++e)
            sizes[e] = size_of_index(level - 1, page * kPageEntries + e);
        return sizes;
    }

    std::vector<std::vector<std::byte>> encode(Batch& batch) const {
        std::vector<std::vector<std::byte>> coded(batch.count());
        core::parallel_for(
            coded.size(), [&](size_t i) { coded[i] = encode(batch, i); }, 16);
        return coded;
    }

    // A block that would not come back as it is, or not smaller, is stored as it is: the reader tells by its
    // size.
    std::vector<std::byte> encode(Batch& batch, size_t i) const {
        std::vector<std::byte> coded, again;
        bool comes_back = false;
        if (batch.are_runs(i)) {
            const PlainRuns runs = batch.runs(i);
            again.resize(runs.bytes.size());
            if (run_codec_.can_code(runs)) coded = run_codec_.encode(runs, *encoding_);
            comes_back = run_codec_.decode(coded, *decoding_, again);
        } else {
            const PlainBlock block = batch.nodes(i);
            again.resize(block.bytes.size());
            if (codec_.can_code(block)) coded = codec_.encode(block, *encoding_);
            comes_back = codec_.decode(block.number, coded, *decoding_, again);
        }
        const std::span<const std::byte> plain = batch.nodes(i).bytes;
        if (comes_back && coded.size() < plain.size() &&
            std::equal(again.begin(), again.end(), plain.begin()))
            return coded;
        return {plain.begin(), plain.end()};
    }

    void write_batch(uint64_t first, const std::vector<std::vector<std::byte>>& coded,
                     core::OutputFile& out) const {
        for (size_t i = 0; i < coded.size(); ++i) {
            if ((first + i) % kPageEntries == 0) write_pages(first + i, std::span(coded).subspan(i), out);
            out.write(coded[i]);
        }
    }

    // The pages that begin with a block, the coarsest first.
    void write_pages(uint64_t block, std::span<const std::vector<std::byte>> coded,
                     core::OutputFile& out) const {
        for (uint32_t level = index_.levels(); level-- > 1;) {
            if (block % (uint64_t(1) << 8 * (level + 1)) != 0) continue;
            const uint64_t page = block >> 8 * (level + 1);
            out.write(index_.encode_page(level, page, sizes_of(level, page)));
        }
        std::vector<uint64_t> sizes;
        for (const auto& one : coded.first(std::min<size_t>(coded.size(), kPageEntries)))
            sizes.push_back(one.size());
        out.write(index_.encode_page(0, block / kPageEntries, sizes));
    }

    const PlainModel& model_;
    const BlockCodec codec_;
    const RunCodec run_codec_;
    const BlockIndex index_;
    const uint32_t version_;
    std::vector<std::byte> tables_bytes_;
    SymbolShares shares_;
    std::optional<EncodingTables> encoding_;
    std::optional<DecodingTables> decoding_;
    CompressedSizes sizes_;
    std::vector<uint64_t> run_sizes_;  // of 256 blocks and their page
};

}  // namespace

PlainModel plain_of(const Model& model) {
    return {model.header(), model.header_bytes(), [&model](uint64_t number, std::span<std::byte> block) {
                const auto bytes = model.any_block(number);
                std::copy(bytes.begin(), bytes.end(), block.begin());
            }};
}

CompressedSizes write_compressed(const PlainModel& model, core::OutputFile& out) {
    return Compressor(model).write(out);
}

uint64_t write_plain(const PlainModel& model, core::OutputFile& out) {
    const Header& h = model.header;
    out.write(model.header_bytes);
    out.write(kGap);
    std::vector<std::byte> bytes;
    for (uint64_t first = 0; first < h.block_count; first += kBatchBlocks) {
        const uint64_t count = std::min(kBatchBlocks, h.block_count - first);
        bytes.assign(count * h.block_size, std::byte{0});
        core::parallel_for(
            count,
            [&](size_t i) {
                model.read(first + i, std::span(bytes).subspan(i * h.block_size, h.block_size));
            },
            16);
        out.write(bytes);
    }
    return h.plain_bytes();
}

CompressedSizes sizes_of(const CodedFile& file) {
    CompressedSizes sizes;
    const uint64_t blocks = file.header().block_count;
    sizes.file_bytes = file.file_size();
    sizes.table_bytes = file.tables_size();
    sizes.index_bytes = file.index().total_bytes();
    sizes.block_size = file.header().block_size;
    sizes.field_bits.resize(kSymbolFields.size());
    for (uint64_t b = 0; b < blocks; ++b) sizes.blocks_as_they_are += !file.measure(b, sizes.field_bits);
    return sizes;
}

}  // namespace splat
