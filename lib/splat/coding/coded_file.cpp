#include "splat/coding/coded_file.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/bytes.h"
#include "core/error.h"

namespace splat {

namespace {

constexpr uint64_t kMaxFileSize = uint64_t(1) << 47;  // twice the largest plain file
constexpr uint64_t kMinBlockInFile = std::min(kMinCodedBlock, kMinCodedRuns) + 2;

CodedHeader checked(const CodedHeader& coded, const Header& header, const std::string& name) {
    // No count is believed that the file has no room for: tables in memory are sized by them.
    if (header.block_count > (coded.file_size - coded.size()) / kMinBlockInFile)
        throw core::Error(core::text("%s: header: %llu blocks do not go with a file of %llu bytes",
                                     name.c_str(), static_cast<unsigned long long>(header.block_count),
                                     static_cast<unsigned long long>(coded.file_size)));
    return coded;
}

}  // namespace

uint64_t CodedHeader::size() const {
    return kCodedHeaderSize + plain.size() + tables.size() + 8;
}

std::vector<std::byte> encode_coded_header(const CodedHeader& header) {
    core::ByteWriter out;
    for (const char c : kCodedMagic) out.put(c);
    out.put(header.version);
    out.put(uint32_t(header.tables.size()));
    out.put(header.file_size);
    out.bytes.insert(out.bytes.end(), header.plain.begin(), header.plain.end());
    out.bytes.insert(out.bytes.end(), header.tables.begin(), header.tables.end());
    out.put(uint64_t(XXH3_64bits(out.bytes.data(), out.bytes.size())));
    return std::move(out.bytes);
}

uint64_t coded_header_bytes(std::span<const std::byte> head) {
    core::ByteReader r(head, "");
    r.take<uint64_t>(), r.take<uint32_t>();
    // Longer tables are refused when they are parsed; nobody waits for them.
    return kCodedHeaderSize + kHeaderSize + std::min<uint64_t>(r.take<uint32_t>(), kMaxTableBytes) + 8;
}

CodedHeader parse_coded_header(std::span<const std::byte> file, const std::string& name) {
    core::ByteReader r(file, name);
    r.take<uint64_t>();
    const auto version = r.take<uint32_t>();
    if (version < 1 || version > kCodedVersion)
        throw core::Error(core::text("%s: compressed format version %u, this program reads versions 1 to %u",
                                     name.c_str(), version, kCodedVersion));
    const auto tables_size = r.take<uint32_t>();
    CodedHeader header;
    header.version = version;
    header.file_size = r.take<uint64_t>();
    const auto refuse = [&](const std::string& what) { throw core::Error(name + ": header: " + what); };
    if (tables_size > kMaxTableBytes)
        refuse(
            core::text("symbol tables of %u bytes, at most %zu are possible", tables_size, kMaxTableBytes));
    const uint64_t sum_at = kCodedHeaderSize + kHeaderSize + tables_size, size = sum_at + 8;
    if (header.file_size <= size || header.file_size > kMaxFileSize)
        refuse(core::text("a file of %llu bytes is not possible",
                          static_cast<unsigned long long>(header.file_size)));
    if (file.size() < size)
        throw core::Error(core::text("%s: cut off at byte %zu, the header has %llu", name.c_str(),
                                     file.size(), static_cast<unsigned long long>(size)));
    uint64_t sum;
    std::memcpy(&sum, file.data() + sum_at, sizeof(sum));
    const uint64_t found = XXH3_64bits(file.data(), sum_at);
    if (sum != found) refuse(core::wrong_checksum(found, sum, 16));
    header.plain = file.subspan(kCodedHeaderSize, kHeaderSize);
    header.tables = file.subspan(kCodedHeaderSize + kHeaderSize, tables_size);
    return header;
}

CodedFile::CodedFile(std::span<const std::byte> file, const std::string& name)
    : CodedFile(
          file, [](const CodedPlace&) { return true; }, name) {}

CodedFile::CodedFile(std::span<const std::byte> file, IsThere is_there, const std::string& name)
    : file_(file),
      name_(name),
      is_there_(std::move(is_there)),
      coded_(parse_coded_header(file, name)),
      header_(parse_header(coded_.plain, name)),
      index_(checked(coded_, header_, name).size() > 0 ? header_.block_count : 1),
      tables_(decode_tables(coded_.tables, coded_.symbol_kinds(), name)),
      codec_(header_),
      run_codec_(header_) {
    if (file.size() > coded_.file_size)
        throw core::Error(core::text("%s: %zu bytes, its header says %llu", name.c_str(), file.size(),
                                     static_cast<unsigned long long>(coded_.file_size)));
}

uint64_t CodedFile::count_present() const {
    return index_.count_present(file_, coded_.size(), coded_.file_size, name_);
}

CodedPlace CodedFile::place_of(uint64_t number) const {
    const FoundPlace found = look_up(number);
    if (!found.is_block) fault(number, found.place, "the page of the index that finds it is not there");
    return found.place;
}

FoundPlace CodedFile::look_up(uint64_t number) const {
    return index_.look_up(file_, coded_.size(), coded_.file_size, number, is_there_, name_);
}

void CodedFile::fault(uint64_t number, const CodedPlace& place, const std::string& what) const {
    throw core::Error(core::text("%s: block %llu at byte %llu: %s", name_.c_str(),
                                 static_cast<unsigned long long>(number),
                                 static_cast<unsigned long long>(place.offset), what.c_str()));
}

void CodedFile::read(uint64_t number, std::span<std::byte> block) const {
    const CodedPlace place = place_of(number);
    if (place.size > block.size())
        fault(number, place,
              core::text("%llu bytes, more than a block has", static_cast<unsigned long long>(place.size)));
    const auto coded = file_.subspan(place.offset, place.size);
    if (place.size == block.size())
        std::copy(coded.begin(), coded.end(), block.begin());
    else if (!(number < header_.node_blocks() ? codec_.decode(number, coded, tables_, block)
                                              : run_codec_.decode(coded, tables_, block)))
        fault(number, place, "its coding is damaged: copy or build the file again");
}

bool CodedFile::measure(uint64_t number, std::span<double> bits) const {
    const CodedPlace place = place_of(number);
    if (place.size >= header_.block_size) return false;
    const auto coded = file_.subspan(place.offset, place.size);
    return number < header_.node_blocks() ? codec_.measure(coded, tables_, bits)
                                          : run_codec_.measure(coded, tables_, header_.block_size, bits);
}

}  // namespace splat
