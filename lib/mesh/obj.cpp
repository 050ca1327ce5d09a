#include "mesh/obj.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "mesh/text.h"

namespace mesh {

namespace {

constexpr std::array<std::string_view, 44> kKeywords{
    "v",        "vt",   "vn",         "vp",        "f",      "fo",     "l",      "p",     "g",
    "o",        "s",    "mg",         "usemtl",    "mtllib", "usemap", "maplib", "bevel", "c_interp",
    "d_interp", "lod",  "shadow_obj", "trace_obj", "ctech",  "stech",  "cstype", "deg",   "bmat",
    "step",     "curv", "curv2",      "surf",      "parm",   "trim",   "hole",   "scrv",  "sp",
    "end",      "con",  "call",       "csh",       "bzp",    "bsp",    "cdc",    "res"};

class ObjReader {
  public:
    ObjReader(const Source& source, const ReadOptions& options)
        : source_(source),
          options_(options),
          text_(source, 0, '#'),
          vertex_count_(count_lines(source, "v")) {}

    ReadResult read() {
        result_.counts.format = "obj";
        result_.counts.vertices_in = vertex_count_;
        Faces faces(source_, vertex_count_, result_);
        points_.reserve(vertex_count_);
        for (std::string_view keyword = text_.word(); !keyword.empty(); keyword = text_.word()) {
            if (keyword == "v")
                read_vertex();
            else if (keyword == "vn")
                read_normal();
            else if (keyword == "f" || keyword == "fo")
                read_face(faces);
            else if (!is_obj_keyword(keyword))
                text_.fail(quoted(keyword) + " is not a keyword of OBJ");
            skip_line();
        }
        place_points(points_, result_.mesh);
        settle_normals();
        if (colours_.size() == points_.size()) result_.mesh.colours = std::move(colours_);
        settle_bad_vertices(source_, options_, true, result_);
        return std::move(result_);
    }

  private:
    static size_t count_lines(const Source& source, std::string_view keyword) {
        TextReader text(source, 0, '#');
        size_t count = 0;
        for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
            count += word == keyword;
            while (!next_in_line(text).empty()) continue;
        }
        return count;
    }

    // The line's next word; a backslash at its end joins the next line to it.
    static std::string_view next_in_line(TextReader& text) {
        std::string_view word = text.word_in_line();
        while (word == "\\" && text.next_line()) word = text.word_in_line();
        return word;
    }

    std::string_view next() { return next_in_line(text_); }

    void skip_line() {
        while (!next().empty()) continue;
    }

    void read_vertex() {
        const auto rest = [&] { return next(); };
        points_.push_back(text_.point(next(), rest, options_.skip_bad));
        // What follows is a weight, a colour, or both in this order.
        std::array<double, 4> more{};
        size_t count = 0;
        for (std::string_view word = next(); !word.empty() && count < more.size(); word = next())
            more[count++] = text_.number(word);
        if (count >= 3)
            colours_.emplace_back(colour_from_fraction(more[count - 3]),
                                  colour_from_fraction(more[count - 2]),
                                  colour_from_fraction(more[count - 1]));
    }

    void read_normal() {
        const auto rest = [&] { return next(); };
        normals_.push_back(unit_normal(text_.three(next(), rest, "components of a normal")));
    }

    void read_face(Faces& faces) {
        corners_.clear();
        for (std::string_view word = next(); !word.empty(); word = next()) {
            const size_t slash = word.find('/');
            const int64_t vertex =
                index_of(word.substr(0, slash), points_.size(), vertex_count_, "vertex", "vertices");
            corners_.push_back(vertex);
            const size_t second = slash == word.npos ? slash : word.find('/', slash + 1);
            if (second != word.npos && second + 1 < word.size())
                set_normal(static_cast<size_t>(vertex), word.substr(second + 1));
        }
        faces.polygon(corners_);
    }

    // From 1 upwards, or backwards from the last one `so_far`, to one from 0.
    int64_t index_of(std::string_view word, size_t so_far, size_t count, const char* one,
                     const char* many) const {
        const int64_t index = text_.integer(word);
        // so_far is far below 2^63 and index negative: no overflow.
        const int64_t from_zero = index < 0 ? static_cast<int64_t>(so_far) + index : index - 1;
        if (index == 0 || from_zero < 0 || static_cast<uint64_t>(from_zero) >= count)
            text_.fail(core::text("face %llu uses %s %lld, file has %zu %s",
                                  static_cast<unsigned long long>(result_.counts.faces_in), one,
                                  static_cast<long long>(index), count, many));
        return from_zero;
    }

    void set_normal(size_t vertex, std::string_view word) {
        const auto index = static_cast<size_t>(
            index_of(word, normals_.size(), normals_.size(), "normal", "normals before it"));
        if (vertex_normals_.empty()) vertex_normals_.assign(vertex_count_, glm::vec3(0));
        glm::vec3& normal = vertex_normals_[vertex];
        if (normal != glm::vec3(0) && normal != normals_[index]) has_two_normals_ = true;
        normal = normals_[index];
    }

    void settle_normals() {
        if (has_two_normals_) return;
        if (!vertex_normals_.empty())
            result_.mesh.normals = std::move(vertex_normals_);
        else if (normals_.size() == points_.size())
            result_.mesh.normals = std::move(normals_);  // a cloud, or faces that name only vertices
    }

    const Source& source_;
    const ReadOptions& options_;
    TextReader text_;
    size_t vertex_count_;
    ReadResult result_;
    std::vector<glm::dvec3> points_;
    std::vector<glm::u8vec3> colours_;
    std::vector<glm::vec3> normals_;         // in the file's order
    std::vector<glm::vec3> vertex_normals_;  // as faces give them to vertices; zero: not yet
    bool has_two_normals_ = false;           // some vertex has
    std::vector<int64_t> corners_;           // of the face being read
};

}  // namespace

bool is_obj_keyword(std::string_view keyword) {
    return std::find(kKeywords.begin(), kKeywords.end(), keyword) != kKeywords.end();
}

ReadResult read_obj(const Source& source, const ReadOptions& options) {
    return ObjReader(source, options).read();
}

}  // namespace mesh
