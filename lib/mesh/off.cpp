#include "mesh/off.h"

#include <algorithm>

#include "core/error.h"
#include "mesh/text.h"

namespace mesh {

namespace {

struct Variant {
    bool is_off = false;
    bool has_normals = false, has_colours = false, has_other_dimension = false;
};

// The keyword is [ST][C][N][4][n]OFF.
Variant variant_of(std::string_view word) {
    Variant variant;
    const auto eat = [&](std::string_view prefix) {
        if (!word.starts_with(prefix)) return false;
        word.remove_prefix(prefix.size());
        return true;
    };
    eat("ST");
    variant.has_colours = eat("C");
    variant.has_normals = eat("N");
    variant.has_other_dimension = eat("4");
    variant.has_other_dimension |= eat("n");
    variant.is_off = word == "OFF";
    return variant;
}

class OffReader {
  public:
    OffReader(const Source& source, const ReadOptions& options)
        : source_(source), options_(options), text_(source, 0, '#') {}

    ReadResult read() {
        result_.counts.format = "off";
        read_header();
        Faces faces(source_, vertex_count_, result_);
        points_.reserve(vertex_count_);
        for (uint64_t v = 0; v < vertex_count_; ++v) read_vertex(v);
        for (uint64_t f = 0; f < face_count_; ++f) read_face(f, faces);
        if (const std::string_view extra = text_.word(); !extra.empty())
            text_.fail(quoted(extra) + " stands after the last face");
        place_points(points_, result_.mesh);
        settle_colours();
        settle_bad_vertices(source_, options_, true, result_);
        return std::move(result_);
    }

  private:
    void read_header() {
        std::string_view word = text_.word();
        variant_ = variant_of(word);
        if (variant_.is_off)
            word = text_.word();
        else
            variant_ = {};  // the keyword may be left out
        if (variant_.has_other_dimension) text_.fail("only three-dimensional OFF is read");
        if (word == "BINARY") text_.fail("binary OFF is not read");
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

    // Files have colours as bytes or as fractions, and do not say which.
    void settle_colours() {
        double largest = 0;
        for (const glm::dvec3& c : colours_) largest = std::max({largest, c.x, c.y, c.z});
        const double one = largest > 1 ? 255 : 1;
        for (const glm::dvec3& c : colours_)
            result_.mesh.colours.emplace_back(colour_from_fraction(c.x / one),
                                              colour_from_fraction(c.y / one),
                                              colour_from_fraction(c.z / one));
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
