#include "mesh/off.h"

#include <algorithm>
#include <bit>

#include "core/error.h"
#include "mesh/text.h"

namespace mesh {

namespace {

struct Variant {
    bool is_off = false;
    bool has_normals = false, has_colours = false, has_texture = false, has_other_dimension = false;
};

// The keyword is [ST][C][N][4][n]OFF.
Variant variant_of(std::string_view word) {
    Variant variant;
    const auto eat = [&](std::string_view prefix) {
        if (!word.starts_with(prefix)) return false;
        word.remove_prefix(prefix.size());
        return true;
    };
    variant.has_texture = eat("ST");
    variant.has_colours = eat("C");
    variant.has_normals = eat("N");
    variant.has_other_dimension = eat("4");
    variant.has_other_dimension |= eat("n");
    variant.is_off = word == "OFF";
    return variant;
}

// Files have colours as bytes or as fractions, and do not say which.
void settle_colours(const std::vector<glm::dvec3>& colours, Mesh& mesh) {
    double largest = 0;
    for (const glm::dvec3& c : colours) largest = std::max({largest, c.x, c.y, c.z});
    const double one = largest > 1 ? 255 : 1;
    for (const glm::dvec3& c : colours)
        mesh.colours.emplace_back(colour_from_fraction(c.x / one), colour_from_fraction(c.y / one),
                                  colour_from_fraction(c.z / one));
}

// What follows the line of "BINARY": 32-bit integers and floats, the most significant byte first, as Geomview
// has them.  Counts of vertices, faces and edges; for each vertex 3 coordinates, then as the keyword says 3
// of a normal, 4 of a colour, 2 of a texture; for each face the number of its corners, these, and the number
// of its colour's components and these.
class BinaryOffReader {
  public:
    BinaryOffReader(const Source& source, const ReadOptions& options, const Variant& variant, size_t at)
        : source_(source), options_(options), variant_(variant), at_(at) {}

    ReadResult read() {
        result_.counts.format = "off binary";
        const uint64_t vertex_bytes = kWordBytes * (3u + 3u * variant_.has_normals +
                                                    4u * variant_.has_colours + 2u * variant_.has_texture);
        const uint64_t vertex_count = take_count(kHeader, "vertices");
        const uint64_t face_count = take_count(kHeader, "faces");
        take_word(kHeader);  // edges, which nobody needs
        expect_room(kHeader, "vertices", vertex_count, vertex_bytes);
        expect_room(kHeader, "faces", face_count, 2 * kWordBytes);
        result_.counts.vertices_in = vertex_count;
        Faces faces(source_, vertex_count, result_);
        result_.mesh.positions.reserve(vertex_count);
        for (uint64_t v = 0; v < vertex_count; ++v) read_vertex({"vertex", v});
        for (uint64_t f = 0; f < face_count; ++f) read_face({"face", f}, faces);
        if (bytes_left() > 0)
            throw core::Error(
                core::text("%s: %zu bytes stand after the last face", source_.name.c_str(), bytes_left()));
        settle_colours(colours_, result_.mesh);
        settle_bad_vertices(source_, options_, false, result_);
        return std::move(result_);
    }

  private:
    static constexpr uint64_t kWordBytes = 4;

    // Where an error is, made into words only when there is one.
    struct Place {
        const char* what;
        uint64_t number;
    };
    static constexpr uint64_t kNoNumber = ~uint64_t{0};
    static constexpr Place kHeader{"header", kNoNumber};

    [[noreturn]] void fail(const Place& place, const std::string& what) const {
        std::string where = place.what;
        if (place.number != kNoNumber)
            where += core::text(" %llu", static_cast<unsigned long long>(place.number));
        throw core::Error(source_.name + ": " + where + ": " + what);
    }

    size_t bytes_left() const { return source_.bytes.size() - at_; }

    // `smallest`: bytes that each of them takes at least.
    void expect_room(const Place& where, const char* what, uint64_t count, uint64_t smallest) const {
        if (count > bytes_left() / smallest)
            fail(where, core::text("%llu %s in the %zu bytes that are left",
                                   static_cast<unsigned long long>(count), what, bytes_left()));
    }

    uint32_t take_word(const Place& where) {
        if (bytes_left() < kWordBytes)
            fail(where, core::text("the file ends at byte %zu", source_.bytes.size()));
        uint32_t word = 0;
        for (size_t k = 0; k < kWordBytes; ++k)
            word = word << 8 | std::to_integer<uint32_t>(source_.bytes[at_++]);
        return word;
    }

    uint64_t take_count(const Place& where, const char* what) {
        const auto count = static_cast<int32_t>(take_word(where));
        if (count < 0) fail(where, core::text("%d %s", count, what));
        return static_cast<uint64_t>(count);
    }

    glm::vec3 take_three(const Place& where) {
        glm::vec3 out;
        for (int k = 0; k < 3; ++k) out[k] = std::bit_cast<float>(take_word(where));
        return out;
    }

    void read_vertex(const Place& where) {
        result_.mesh.positions.push_back(take_three(where));
        if (variant_.has_normals) result_.mesh.normals.push_back(unit_normal(take_three(where)));
        if (variant_.has_colours) {
            colours_.emplace_back(take_three(where));
            take_word(where);  // opacity
        }
        if (variant_.has_texture) take_word(where), take_word(where);
    }

    void read_face(const Place& where, Faces& faces) {
        const uint64_t corner_count = take_count(where, "corners");
        expect_room(where, "corners", corner_count, kWordBytes);
        corners_.clear();
        for (uint64_t k = 0; k < corner_count; ++k)
            corners_.push_back(static_cast<int32_t>(take_word(where)));
        faces.polygon(corners_);
        const uint64_t components = take_count(where, "colour components");
        expect_room(where, "colour components", components, kWordBytes);
        at_ += kWordBytes * components;
    }

    const Source& source_;
    const ReadOptions& options_;
    Variant variant_;
    size_t at_;
    ReadResult result_;
    std::vector<glm::dvec3> colours_;
    std::vector<int64_t> corners_;  // of the face being read
};

class OffReader {
  public:
    OffReader(const Source& source, const ReadOptions& options)
        : source_(source), options_(options), text_(source, 0, '#') {}

    ReadResult read() {
        result_.counts.format = "off";
        std::string_view word = text_.word();
        variant_ = variant_of(word);
        if (variant_.is_off)
            word = text_.word();
        else
            variant_ = {};  // the keyword may be left out
        if (variant_.has_other_dimension) text_.fail("only three-dimensional OFF is read");
        if (word == "BINARY") {
            text_.next_line();
            return BinaryOffReader(source_, options_, variant_, text_.position()).read();
        }
        read_counts(word);
        Faces faces(source_, vertex_count_, result_);
        points_.reserve(vertex_count_);
        for (uint64_t v = 0; v < vertex_count_; ++v) read_vertex(v);
        for (uint64_t f = 0; f < face_count_; ++f) read_face(f, faces);
        if (const std::string_view extra = text_.word(); !extra.empty())
            text_.fail(quoted(extra) + " stands after the last face");
        place_points(points_, result_.mesh);
        settle_colours(colours_, result_.mesh);
        settle_bad_vertices(source_, options_, true, result_);
        return std::move(result_);
    }

  private:
    void read_counts(std::string_view word) {
        vertex_count_ = read_count(word, 6, "vertices");
        face_count_ = read_count(text_.word(), 2, "faces");
        skip_line();  // the number of edges, which nobody needs
        result_.counts.vertices_in = vertex_count_;
    }

    // A claim that the bytes left can hold: `smallest` bytes a record.
    uint64_t read_count(std::string_view word, size_t smallest, const char* what) const {
        const int64_t count = text_.integer(word);
        if (count < 0 || static_cast<uint64_t>(count) > (text_.bytes_left() + 1) / smallest)
            text_.fail(core::text("%lld %s in the %zu bytes that are left", static_cast<long long>(count),
                                  what, text_.bytes_left()));
        return static_cast<uint64_t>(count);
    }

    void skip_line() {
        while (!text_.word_in_line().empty()) continue;
    }

    void read_vertex(uint64_t v) {
        const std::string_view word = text_.word();
        if (word.empty())
            text_.fail(core::text("the file ends after %llu of %llu vertices",
                                  static_cast<unsigned long long>(v),
                                  static_cast<unsigned long long>(vertex_count_)));
        const auto next = [&] { return text_.word_in_line(); };
        points_.push_back(text_.point(word, next, options_.skip_bad));
        if (variant_.has_normals)
            result_.mesh.normals.push_back(unit_normal(text_.three(next(), next, "normal components")));
        if (variant_.has_colours) colours_.push_back(text_.three(next(), next, "colour components"));
        skip_line();
    }

    void read_face(uint64_t f, Faces& faces) {
        const std::string_view word = text_.word();
        if (word.empty())
            text_.fail(core::text("the file ends after %llu of %llu faces",
                                  static_cast<unsigned long long>(f),
                                  static_cast<unsigned long long>(face_count_)));
        const int64_t count = text_.integer(word);
        corners_.clear();
        for (int64_t k = 0; k < count; ++k) {
            const std::string_view corner = text_.word_in_line();
            if (corner.empty())
                text_.fail(core::text("expected %lld corners, found %lld", static_cast<long long>(count),
                                      static_cast<long long>(k)));
            corners_.push_back(text_.integer(corner));
        }
        faces.polygon(corners_);
        skip_line();
    }

    const Source& source_;
    const ReadOptions& options_;
    TextReader text_;
    Variant variant_;
    uint64_t vertex_count_ = 0, face_count_ = 0;
    ReadResult result_;
    std::vector<glm::dvec3> points_, colours_;
    std::vector<int64_t> corners_;  // of the face being read
};

}  // namespace

bool is_off_keyword(std::string_view word) {
    return variant_of(word).is_off;
}

ReadResult read_off(const Source& source, const ReadOptions& options) {
    return OffReader(source, options).read();
}

}  // namespace mesh
