#include "mesh/stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "core/error.h"
#include "mesh/text.h"

namespace mesh {

namespace {

constexpr size_t kHeaderBytes = 84, kTriangleBytes = 50;

// Gives equal points (bit by bit, but 0 and -0 are equal) one index: an open-addressing table of
// the indices of `points`, at most half full.
template <class Point>
class Weld {
  public:
    std::vector<Point> points;  // without repeats, in the order of first use

    uint32_t index_of(Point point) {
        point += typename Point::value_type(0);  // -0 becomes 0
        if (2 * points.size() >= slots_.size()) grow();
        uint32_t& slot = find(point);
        if (slot == kEmpty) {
            slot = static_cast<uint32_t>(points.size());
            points.push_back(point);
        }
        return slot;
    }

  private:
    static constexpr uint32_t kEmpty = ~uint32_t{0};
    using Bits = std::array<std::conditional_t<sizeof(Point) == 12, uint32_t, uint64_t>, 3>;

    static uint64_t hash(const Bits& bits) {
        uint64_t h = 0;
        for (const auto b : bits) {
            h ^= b;
            h *= 0x9e3779b97f4a7c15u;  // 2^64 over the golden ratio: spreads low bits upwards
            h ^= h >> 32;
        }
        return h;
    }

    uint32_t& find(const Point& point) {
        const Bits bits = std::bit_cast<Bits>(point);
        size_t at = hash(bits) & (slots_.size() - 1);
        while (slots_[at] != kEmpty && std::bit_cast<Bits>(points[slots_[at]]) != bits)
            at = (at + 1) & (slots_.size() - 1);
        return slots_[at];
    }

    void grow() {
        slots_.assign(std::max<size_t>(1024, 4 * points.size()), kEmpty);
        slots_.resize(std::bit_ceil(slots_.size()), kEmpty);
        for (size_t i = 0; i < points.size(); ++i) find(points[i]) = static_cast<uint32_t>(i);
    }

    std::vector<uint32_t> slots_;
};

template <class Point>
void add_facet(const Source& source, const std::array<Point, 3>& corners, Weld<Point>& weld,
               ReadResult& result) {
    if (weld.points.size() > ~uint32_t{0} - 8u) throw core::Error(source.name + ": more than 2^32 vertices");
    ++result.counts.faces_in;
    ++result.counts.triangles_in;
    result.counts.vertices_in += 3;
    const uint32_t a = weld.index_of(corners[0]);
    const uint32_t b = weld.index_of(corners[1]);
    const uint32_t c = weld.index_of(corners[2]);
    result.mesh.triangles.emplace_back(a, b, c);
}

void count_welded(size_t vertices, ReadResult& result) {
    if (const uint64_t welded = result.counts.vertices_in - vertices; welded != 0)
        result.counts.vertices_dropped["welded"] = welded;
    drop_repeated(result);
}

uint32_t claimed_triangles(const Source& source) {
    uint32_t count;
    std::memcpy(&count, source.bytes.data() + kHeaderBytes - sizeof count, sizeof count);
    return count;
}

ReadResult read_binary(const Source& source, const ReadOptions& options) {
    if (source.bytes.size() < kHeaderBytes)
        throw core::Error(core::text("%s: header: %zu bytes, a binary STL has at least %zu",
                                     source.name.c_str(), source.bytes.size(), kHeaderBytes));
    const uint32_t count = claimed_triangles(source);
    if (!is_binary_stl(source))
        throw core::Error(core::text(
            "%s: header: %u triangles make %llu bytes, the file has %zu", source.name.c_str(), count,
            static_cast<unsigned long long>(kHeaderBytes + uint64_t{kTriangleBytes} * count),
            source.bytes.size()));
    ReadResult result;
    result.counts.format = "stl binary";
    result.mesh.triangles.reserve(count);
    Weld<glm::vec3> weld;
    for (uint32_t t = 0; t < count; ++t) {
        constexpr size_t kNormalBytes = 12;
        std::array<glm::vec3, 3> corners;
        std::memcpy(corners.data(), source.bytes.data() + kHeaderBytes + kTriangleBytes * t + kNormalBytes,
                    sizeof corners);
        add_facet(source, corners, weld, result);
    }
    result.mesh.positions = std::move(weld.points);
    count_welded(result.mesh.positions.size(), result);
    settle_bad_vertices(source, options, false, result);
    return result;
}

class AsciiStlReader {
  public:
    AsciiStlReader(const Source& source, const ReadOptions& options)
        : source_(source), options_(options), text_(source, 0, 0) {}

    ReadResult read() {
        result_.counts.format = "stl ascii";
        bool is_open = false;
        for (std::string keyword = next(); !keyword.empty(); keyword = next()) {
            if (keyword == "solid") {
                is_open = true;
            } else if (keyword == "endsolid") {
                is_open = false;
            } else if (keyword == "vertex") {
                read_corner();
            } else if (keyword == "endloop") {
                if (count_ != 3) text_.fail(core::text("a facet of %zu vertices", count_));
                add_facet(source_, corners_, weld_, result_);
                count_ = 0;
            } else if (keyword != "facet" && keyword != "outer" && keyword != "endfacet") {
                text_.fail(quoted(keyword) + " is not a keyword of STL");
            }
            while (!text_.word_in_line().empty()) continue;
        }
        if (is_open) text_.fail("the file ends without 'endsolid'");
        place_points(weld_.points, result_.mesh);
        count_welded(weld_.points.size(), result_);
        settle_bad_vertices(source_, options_, true, result_);
        return std::move(result_);
    }

  private:
    std::string next() {
        std::string word(text_.word());
        std::transform(word.begin(), word.end(), word.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        return word;
    }

    void read_corner() {
        if (count_ == corners_.size()) text_.fail("a facet of more than 3 vertices");
        const auto next_word = [&] { return text_.word_in_line(); };
        corners_[count_++] = text_.point(next_word(), next_word, options_.skip_bad);
    }

    const Source& source_;
    const ReadOptions& options_;
    TextReader text_;
    ReadResult result_;
    Weld<glm::dvec3> weld_;
    std::array<glm::dvec3, 3> corners_;  // of the facet being read
    size_t count_ = 0;                   // how many of them are there
};

}  // namespace

bool is_binary_stl(const Source& source) {
    return source.bytes.size() >= kHeaderBytes &&
           source.bytes.size() == kHeaderBytes + uint64_t{kTriangleBytes} * claimed_triangles(source);
}

ReadResult read_stl(const Source& source, const ReadOptions& options) {
    const std::string_view text = source.text();
    const bool is_text = (text.starts_with("solid") || text.starts_with("SOLID")) && !is_binary_stl(source) &&
                         text.substr(0, kHeaderBytes).find('\0') == text.npos;
    if (is_text) return AsciiStlReader(source, options).read();
    return read_binary(source, options);
}

}  // namespace mesh
