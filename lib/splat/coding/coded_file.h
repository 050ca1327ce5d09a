// Reading a compressed model: a container around the plain header, symbol tables, and coded blocks among the
// pages of their index.  Each block decodes, alone, to the bytes that it has in the plain file.  man/qs.5
// specifies the bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "splat/coding/block_codec.h"
#include "splat/coding/block_index.h"
#include "splat/coding/run_codec.h"
#include "splat/coding/symbol_tables.h"
#include "splat/format.h"

namespace splat {

struct CodedHeader {
    uint32_t version = kCodedVersion;
    uint64_t file_size = 0;
    std::span<const std::byte> plain;  // header of the plain file
    std::span<const std::byte> tables;
    uint64_t size() const;  // where the index begins
    // Of how many kinds the tables are.
    uint32_t symbol_kinds() const { return version == 1 ? kNodeSymbolKinds : kSymbolKinds; }
};
std::vector<std::byte> encode_coded_header(const CodedHeader& header);
// How many bytes of a compressed file its header takes, told by the first kCodedHeaderSize of them.
uint64_t coded_header_bytes(std::span<const std::byte> head);
// Checks all but what the two parts say.  Throws core::Error "<name>: ...".
CodedHeader parse_coded_header(std::span<const std::byte> file, const std::string& name);

class CodedFile {
  public:
    // `file` must outlive it, and may be a prefix.  Throws core::Error: cut off before the first block,
    // damaged.
    CodedFile(std::span<const std::byte> file, const std::string& name);
    // A whole file that is arriving: its header is there.  Throws core::Error: damaged, or not all of it at
    // its source.
    CodedFile(std::span<const std::byte> file, IsThere is_there, const std::string& name);

    std::span<const std::byte> plain_header() const { return coded_.plain; }
    const Header& header() const { return header_; }
    uint64_t file_size() const { return coded_.file_size; }  // of the whole file
    uint64_t tables_size() const { return coded_.tables.size(); }
    uint64_t header_size() const { return coded_.size(); }
    const BlockIndex& index() const { return index_; }

    uint64_t count_present() const;
    // Where a block is; only blocks that are present may be asked for.
    CodedPlace place_of(uint64_t number) const;
    // Of any block of a file that is arriving: what of it, or of the index, is needed next.
    FoundPlace look_up(uint64_t number) const;

    // Fills `block`, whose bytes are 0 or from an earlier attempt, with the bytes of the plain block, which
    // are not checked yet.  Throws core::Error where they are damaged.  Threads may share it.
    void read(uint64_t number, std::span<std::byte> block) const;

    // Adds what fields take to `bits`, as their codecs' measure(); false for a block that is stored as it is.
    bool measure(uint64_t number, std::span<double> bits) const;

  private:
    [[noreturn]] void fault(uint64_t number, const CodedPlace& place, const std::string& what) const;

    std::span<const std::byte> file_;
    std::string name_;
    IsThere is_there_;
    CodedHeader coded_;
    Header header_;
    BlockIndex index_;
    DecodingTables tables_;
    BlockCodec codec_;
    RunCodec run_codec_;
};

}  // namespace splat
