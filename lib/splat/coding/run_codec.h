// One block of triangles of a compressed model: coded by itself, decoded to the bytes of the plain block.
//
// Runs go on from block to block, so a block begins, as a rule, somewhere in a run.  To take the bits from
// there apart, what a run's head says is needed, and how far it has come; this stands in front, and no more
// is needed: entries and differences are coded as they stand.  What a block has of a step (a triangle, a
// position, a normal) that ends in another stays as it is.  man/qs.5 specifies the bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/coding/symbol_tables.h"
#include "splat/format.h"

namespace splat {

// What a coded block of triangles takes at least: a number, checksum, four states of 30 bits, place and rest.
constexpr size_t kMinCodedRuns = 10;

// How far a run has come.
struct RunPlace {
    enum Part : uint32_t { head, triangles, positions, normals, shading, lost };
    uint32_t part = head;
    uint32_t triangle_count = 0, corner_count = 0, shading_kind = 0, position_width = 0, normal_width = 0;
    uint32_t left = 0;  // steps of the part
    uint32_t had = 0;   // entries that triangles had
    uint32_t cut = 0;   // bits before it of a step that began in the block before
};

// A block as it stands in the file, and where its first bit is in a run.
struct PlainRuns {
    std::span<const std::byte> bytes;
    RunPlace begin;
};

class RunCodec {
  public:
    explicit RunCodec(const Header& header) : lattice_bits_(header.lattice_bits) {}

    // Where the block behind `runs` begins, of which `next` are the bytes, or empty.  Any bytes will do.
    RunPlace end_of(const PlainRuns& runs, std::span<const std::byte> next) const;

    // False where the block holds something else than runs.
    bool can_code(const PlainRuns& runs) const;
    void count(const PlainRuns& runs, SymbolCounts& counts) const;
    std::vector<std::byte> encode(const PlainRuns& runs, const EncodingTables& tables) const;

    // As BlockCodec's.
    bool decode(std::span<const std::byte> coded, const DecodingTables& tables,
                std::span<std::byte> block) const;
    bool measure(std::span<const std::byte> coded, const DecodingTables& tables, uint32_t block_size,
                 std::span<double> bits) const;

  private:
    uint32_t lattice_bits_;
};

}  // namespace splat
