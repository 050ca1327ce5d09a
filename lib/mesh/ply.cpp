#include "mesh/ply.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/error.h"
#include "core/pages.h"
#include "core/parallel.h"
#include "mesh/ply_header.h"
#include "mesh/text.h"

namespace mesh {

namespace {

// Records given to a thread at a time: about 1 MB of file, so that forgetting the pages behind a
// piece is one system call a megabyte.
constexpr size_t kPiece = 65536;

// Vertices converted at a time: their columns stay in the first-level cache.
constexpr size_t kBlock = 512;

template <class T>
T load(const std::byte* at, bool is_swapped) {
    std::array<std::byte, sizeof(T)> bytes;
    std::memcpy(bytes.data(), at, sizeof(T));
    if (is_swapped) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
}

// Calls visit(T{}) with the C++ type of `type`.
template <class Visit>
auto with_type(PlyType type, const Visit& visit) {
    switch (type) {
        case PlyType::int8:
            return visit(int8_t{});
        case PlyType::uint8:
            return visit(uint8_t{});
        case PlyType::int16:
            return visit(int16_t{});
        case PlyType::uint16:
            return visit(uint16_t{});
        case PlyType::int32:
            return visit(int32_t{});
        case PlyType::uint32:
            return visit(uint32_t{});
        case PlyType::float32:
            return visit(float{});
        default:
            return visit(double{});
    }
}

double load_number(PlyType type, const std::byte* at, bool is_swapped) {
    return with_type(type, [&](auto t) { return static_cast<double>(load<decltype(t)>(at, is_swapped)); });
}

// `type` is an integer type.
int64_t load_integer(PlyType type, const std::byte* at, bool is_swapped) {
    return with_type(type, [&](auto t) -> int64_t {
        if constexpr (std::is_integral_v<decltype(t)>) return load<decltype(t)>(at, is_swapped);
        return 0;
    });
}

uint8_t colour_byte(PlyType type, double value) {
    switch (type) {
        case PlyType::float32:
        case PlyType::float64:
            return colour_from_fraction(value);
        case PlyType::uint16:
            return colour_from_fraction(value / 65535);
        default:
            return colour_from_fraction(value / 255);
    }
}

// What we take of a vertex, in the order of its columns.
enum Column { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue, kColumns };

// One of these properties of the vertex element.
struct Field {
    PlyType type = PlyType::float32;
    size_t property = 0;  // index among the element's properties
    size_t offset = 0;    // bytes from the beginning of a record without lists
};

// Where a vertex's columns are found.
struct Layout {
    std::array<std::optional<Field>, kColumns> fields;
    bool has_normals = false, has_colours = false;
    bool is_single = false;  // x, y and z are single-precision numbers, kept as they are

    PlyType type(Column column) const { return fields[column]->type; }
};

using Names = std::array<const char*, 3>;
using Columns = std::array<double, kColumns>;

// The three fields of these names, if all are there.
bool find_fields(const PlyElement& element, const Names& names, Field* fields) {
    for (const char* name : names) {
        size_t offset = 0;
        bool is_found = false;
        for (size_t i = 0; i < element.properties.size() && !is_found; ++i) {
            const PlyProperty& p = element.properties[i];
            is_found = !p.is_list && p.name == name;
            if (is_found) *fields++ = {p.type, i, offset};
            offset += size_of(p.type);
        }
        if (!is_found) return false;
    }
    return true;
}

class PlyReader {
  public:
    PlyReader(const Source& source, const ReadOptions& options)
        : source_(source), options_(options), header_(read_ply_header(source)) {}

    ReadResult read() {
        result_.counts.format = std::string("ply ") + header_.form_name();
        const PlyElement& vertices = find_vertices();
        result_.counts.vertices_in = vertices.count;
        Faces faces(source_, vertices.count, result_);
        find_layout(vertices);
        if (header_.form == PlyForm::ascii)
            read_ascii(vertices, faces);
        else
            read_binary(vertices, faces);
        if (!points_.empty()) place_points(points_, result_.mesh);
        settle_bad_vertices(source_, options_, !layout_.is_single, result_);
        return std::move(result_);
    }

  private:
    [[noreturn]] void fail(const std::string& what) const { throw core::Error(source_.name + ": " + what); }

    const PlyElement& find_vertices() const {
        const PlyElement* found = nullptr;
        for (const PlyElement& element : header_.elements) {
            if (element.name != "vertex") continue;
            if (found != nullptr) fail("header: two elements are called 'vertex'");
            found = &element;
        }
        if (found == nullptr) fail("header: there is no vertex element");
        return *found;
    }

    void find_layout(const PlyElement& vertices) {
        std::array<Field, 3> found;
        const auto take = [&](const Names& names, Column first) {
            if (!find_fields(vertices, names, found.data())) return false;
            std::copy(found.begin(), found.end(), layout_.fields.begin() + first);
            return true;
        };
        if (!take({"x", "y", "z"}, kX)) fail("header: the vertex element lacks x, y or z");
        layout_.has_normals = take({"nx", "ny", "nz"}, kNormalX);
        layout_.has_colours = take({"red", "green", "blue"}, kRed) || take({"r", "g", "b"}, kRed) ||
                              take({"diffuse_red", "diffuse_green", "diffuse_blue"}, kRed);
        layout_.is_single = std::all_of(found_coordinates().begin(), found_coordinates().end(),
                                        [](const auto& f) { return f->type == PlyType::float32; });
    }

    std::span<const std::optional<Field>, 3> found_coordinates() const {
        return std::span<const std::optional<Field>, 3>(layout_.fields.data(), 3);
    }

    // Which property of a face or strip element lists its corners, if any.
    static std::optional<size_t> find_corners(const PlyElement& element) {
        for (size_t i = 0; i < element.properties.size(); ++i) {
            const PlyProperty& p = element.properties[i];
            if (p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index")) return i;
        }
        return std::nullopt;
    }

    // What an element is to us.
    enum class Role { vertices, faces, strips, other };
    Role role_of(const PlyElement& element) const {
        if (element.name == "vertex") return Role::vertices;
        const Role role = element.name == "face"        ? Role::faces
                          : element.name == "tristrips" ? Role::strips
                                                        : Role::other;
        if (role == Role::other || element.count == 0) return Role::other;
        const std::optional<size_t> corners = find_corners(element);
        if (!corners) fail("header: element " + quoted(element.name) + " has no list vertex_indices");
        if (is_float(element.properties[*corners].type))
            fail("header: the vertex indices of element " + quoted(element.name) +
                 " are not of an integer type");
        return role;
    }

    void add_corners(Role role, Faces& faces) {
        if (role == Role::strips)
            faces.strips(corners_);
        else
            faces.polygon(corners_);
    }

    void reserve_vertices(uint64_t count) {
        if (layout_.is_single)
            result_.mesh.positions.reserve(count);
        else
            points_.reserve(count);
        if (layout_.has_normals) result_.mesh.normals.reserve(count);
        if (layout_.has_colours) result_.mesh.colours.reserve(count);
    }

    void add_vertex(const Columns& v) {
        if (layout_.is_single)
            result_.mesh.positions.emplace_back(to_single(v[kX]), to_single(v[kY]), to_single(v[kZ]));
        else
            points_.emplace_back(v[kX], v[kY], v[kZ]);
        if (layout_.has_normals)
            result_.mesh.normals.push_back(unit_normal({v[kNormalX], v[kNormalY], v[kNormalZ]}));
        if (layout_.has_colours)
            result_.mesh.colours.emplace_back(colour_byte(layout_.type(kRed), v[kRed]),
                                              colour_byte(layout_.type(kGreen), v[kGreen]),
                                              colour_byte(layout_.type(kBlue), v[kBlue]));
    }

    // ---- ascii

    void read_ascii(const PlyElement& vertices, Faces& faces) {
        TextReader text(source_, header_.body, 0);
        for (const PlyElement& element : header_.elements) {
            if (element.properties.empty()) continue;  // its records have no bytes
            // A value takes a digit and a blank; the last may lack the blank.
            if (element.count > (text.bytes_left() + 1) / 2 / element.properties.size())
                fail(core::text("header: element %s has %llu records, too many for the %zu bytes left",
                                quoted(element.name).c_str(), static_cast<unsigned long long>(element.count),
                                text.bytes_left()));
            if (&element == &vertices) reserve_vertices(element.count);
            const Role role = role_of(element);
            const size_t corners = role == Role::faces || role == Role::strips ? *find_corners(element) : 0;
            for (uint64_t record = 0; record < element.count; ++record) {
                record_ = record;
                read_ascii_record(text, element, role, corners);
                if (role == Role::vertices) add_vertex(columns_);
                if (role == Role::faces || role == Role::strips) add_corners(role, faces);
                // A value too few or too many would shift all that follows.
                if (!text.word_in_line().empty())
                    text.fail(
                        core::text("%s %llu does not end with its line, as the header's properties would",
                                   element.name.c_str(), static_cast<unsigned long long>(record)));
            }
        }
        if (const std::string_view extra = text.word(); !extra.empty())
            text.fail(quoted(extra) + " stands after the last element of the header");
    }

    void read_ascii_record(TextReader& text, const PlyElement& element, Role role, size_t corners) {
        for (size_t i = 0; i < element.properties.size(); ++i) {
            const PlyProperty& property = element.properties[i];
            if (property.is_list) {
                const bool is_corners = role != Role::vertices && role != Role::other && i == corners;
                read_ascii_list(text, element, is_corners);
                continue;
            }
            const std::string_view word = next_word(text, element);
            if (role != Role::vertices) continue;
            for (size_t c = 0; c < kColumns; ++c)
                if (layout_.fields[c] && layout_.fields[c]->property == i) columns_[c] = text.number(word);
        }
    }

    void read_ascii_list(TextReader& text, const PlyElement& element, bool is_corners) {
        const std::string_view word = next_word(text, element);
        const int64_t count = text.integer(word);
        if (count < 0) text.fail("a list of " + quoted(word) + " values");
        if (is_corners) corners_.clear();
        for (int64_t i = 0; i < count; ++i) {
            const std::string_view value = next_word(text, element);
            if (is_corners) corners_.push_back(text.integer(value));
        }
    }

    std::string_view next_word(TextReader& text, const PlyElement& element) const {
        const std::string_view word = text.word();
        if (word.empty())
            text.fail(core::text("the file ends in %s %llu of %llu", element.name.c_str(),
                                 static_cast<unsigned long long>(record_),
                                 static_cast<unsigned long long>(element.count)));
        return word;
    }

    // ---- binary

    void read_binary(const PlyElement& vertices, Faces& faces) {
        is_swapped_ = header_.form == PlyForm::big_endian;
        at_ = header_.body;
        for (const PlyElement& element : header_.elements) {
            const uint64_t record_bytes = element.smallest_record_bytes();
            if (record_bytes == 0) continue;
            if (element.count > bytes_left() / record_bytes)
                fail(core::text(
                    "header: element %s has %llu records of %s%llu bytes, %zu bytes are left (cut off?)",
                    quoted(element.name).c_str(), static_cast<unsigned long long>(element.count),
                    element.has_list() ? "at least " : "", static_cast<unsigned long long>(record_bytes),
                    bytes_left()));
            const Role role = role_of(element);
            if (!element.has_list()) {
                if (role == Role::vertices) read_plain_vertices(vertices);
                at_ += element.count * record_bytes;
            } else if (role != Role::faces || !read_plain_triangles(element, vertices.count)) {
                read_records(element, role, faces);
            }
        }
        const bool is_padding = std::all_of(source_.bytes.begin() + static_cast<ptrdiff_t>(at_),
                                            source_.bytes.end(), [](std::byte b) {
                                                const char c = static_cast<char>(b);
                                                return c == 0 || c == '\n' || c == '\r' || c == ' ';
                                            });
        if (!is_padding)
            fail(core::text("%zu bytes stand after the last element of the header", bytes_left()));
    }

    size_t bytes_left() const { return source_.bytes.size() - at_; }

    // Vertices of one size: `count` of them are there.
    void read_plain_vertices(const PlyElement& element) {
        const size_t record_bytes = element.smallest_record_bytes();
        const std::byte* first = source_.bytes.data() + at_;
        Mesh& mesh = result_.mesh;
        if (!layout_.is_single) mesh.origin = origin_among_plain_vertices(element);
        core::resize(mesh.positions, element.count);
        if (layout_.has_normals) core::resize(mesh.normals, element.count);
        if (layout_.has_colours) core::resize(mesh.colours, element.count);
        core::parallel_pieces(element.count, kPiece, [&](size_t begin, size_t end) {
            for (size_t v = begin; v < end; v += kBlock)
                convert_block(first + v * record_bytes, record_bytes, v, std::min(kBlock, end - v));
            source_.forget(at_ + begin * record_bytes, at_ + end * record_bytes);
        });
    }

    // One column of `count` records as numbers.
    void gather(Column column, const std::byte* first, size_t record_bytes, size_t count, double* out) const {
        const Field& field = *layout_.fields[column];
        const std::byte* at = first + field.offset;
        with_type(field.type, [&](auto t) {
            for (size_t i = 0; i < count; ++i)
                out[i] = static_cast<double>(load<decltype(t)>(at + i * record_bytes, is_swapped_));
        });
    }

    using Block = std::array<std::array<double, kBlock>, 3>;

    void gather_three(Column column, const std::byte* first, size_t record_bytes, size_t count,
                      Block& out) const {
        for (size_t k = 0; k < 3; ++k)
            gather(static_cast<Column>(column + k), first, record_bytes, count, out[k].data());
    }

    bool has_packed_floats() const {
        return layout_.is_single && !is_swapped_ &&
               layout_.fields[kY]->offset == layout_.fields[kX]->offset + 4 &&
               layout_.fields[kZ]->offset == layout_.fields[kX]->offset + 8;
    }

    void convert_block(const std::byte* first, size_t record_bytes, size_t v, size_t count) {
        Mesh& mesh = result_.mesh;
        Block block;
        if (has_packed_floats()) {
            const std::byte* at = first + layout_.fields[kX]->offset;
            for (size_t i = 0; i < count; ++i) std::memcpy(&mesh.positions[v + i], at + i * record_bytes, 12);
        } else {
            gather_three(kX, first, record_bytes, count, block);
            for (size_t i = 0; i < count; ++i) {
                const glm::dvec3 p(block[0][i], block[1][i], block[2][i]);
                mesh.positions[v + i] = layout_.is_single ? glm::vec3(p) : relative_to(mesh.origin, p);
            }
        }
        if (layout_.has_normals) {
            gather_three(kNormalX, first, record_bytes, count, block);
            for (size_t i = 0; i < count; ++i)
                mesh.normals[v + i] = unit_normal({block[0][i], block[1][i], block[2][i]});
        }
        if (layout_.has_colours) {
            gather_three(kRed, first, record_bytes, count, block);
            for (size_t i = 0; i < count; ++i)
                mesh.colours[v + i] = {colour_byte(layout_.type(kRed), block[0][i]),
                                       colour_byte(layout_.type(kGreen), block[1][i]),
                                       colour_byte(layout_.type(kBlue), block[2][i])};
        }
    }

    glm::dvec3 origin_among_plain_vertices(const PlyElement& element) const {
        const size_t record_bytes = element.smallest_record_bytes();
        const std::byte* first = source_.bytes.data() + at_;
        return origin_among(element.count, [&](uint64_t v) {
            glm::dvec3 point;
            for (int k = 0; k < 3; ++k)
                gather(static_cast<Column>(kX + k), first + v * record_bytes, record_bytes, 1, &point[k]);
            return point;
        });
    }

    // Faces that are all triangles, with one list of 4-byte indices.  False, with nothing done,
    // where they are not, or where an index is out of range (read_records() says which).
    bool read_plain_triangles(const PlyElement& element, uint64_t vertex_count) {
        const size_t corners = *find_corners(element);
        const PlyProperty& list = element.properties[corners];
        const auto lists = std::count_if(element.properties.begin(), element.properties.end(),
                                         [](const auto& p) { return p.is_list; });
        const uint64_t record_bytes = element.smallest_record_bytes() + 12;
        if (lists != 1 || size_of(list.type) != 4 || element.count > bytes_left() / record_bytes ||
            !result_.mesh.triangles.empty())
            return false;
        size_t offset = 0;
        for (size_t i = 0; i < corners; ++i) offset += size_of(element.properties[i].type);
        const std::byte* first = source_.bytes.data() + at_ + offset;
        // A mixed file mostly shows itself in its first record, before memory is taken.
        if (load_integer(list.count_type, first, is_swapped_) != 3) return false;

        const bool is_byte = size_of(list.count_type) == 1;
        std::atomic<bool> is_plain = true, has_repeated = false;
        std::vector<glm::u32vec3>& triangles = result_.mesh.triangles;
        core::resize(triangles, element.count);
        core::parallel_pieces(element.count, kPiece, [&](size_t begin, size_t end) {
            if (!is_plain) return;
            const std::byte* at = first + begin * record_bytes;
            const std::span<glm::u32vec3> out(triangles.data() + begin, end - begin);
            const PieceFound found = is_byte && !is_swapped_
                                         ? unpack_triangles<true>(list.count_type, at, record_bytes, out)
                                         : unpack_triangles<false>(list.count_type, at, record_bytes, out);
            if (!found.is_all_triangles || found.largest_index >= vertex_count) is_plain = false;
            if (found.has_repeated) has_repeated = true;
            source_.forget(at_ + begin * record_bytes, at_ + end * record_bytes);
        });
        if (!is_plain) {
            triangles = {};
            return false;
        }
        result_.counts.faces_in += element.count;
        result_.counts.triangles_in += element.count;
        if (has_repeated) drop_repeated(result_);
        at_ += element.count * record_bytes;
        return true;
    }

    struct PieceFound {
        bool is_all_triangles = true, has_repeated = false;
        uint32_t largest_index = 0;
    };

    // kIsCommon: one byte counts, little-endian.
    template <bool kIsCommon>
    PieceFound unpack_triangles(PlyType count_type, const std::byte* at, size_t record_bytes,
                                std::span<glm::u32vec3> out) const {
        const size_t count_bytes = size_of(count_type);
        PieceFound found;
        // Bits are gathered without branches: the loop runs at memory speed.
        uint32_t not_three = 0, repeated = 0, largest = 0;
        for (glm::u32vec3& t : out) {
            if constexpr (kIsCommon) {
                not_three |= std::to_integer<uint32_t>(*at) ^ 3u;
                std::memcpy(&t, at + 1, 12);
            } else {
                not_three |= load_integer(count_type, at, is_swapped_) != 3;
                for (int k = 0; k < 3; ++k) t[k] = load<uint32_t>(at + count_bytes + 4 * k, is_swapped_);
            }
            repeated |= static_cast<uint32_t>((t.x == t.y) | (t.y == t.z) | (t.z == t.x));
            largest = std::max(largest, std::max(t.x, std::max(t.y, t.z)));
            at += record_bytes;
        }
        found.is_all_triangles = not_three == 0;
        found.has_repeated = repeated != 0;
        found.largest_index = largest;
        return found;
    }

    // Any element with lists, record by record.
    void read_records(const PlyElement& element, Role role, Faces& faces) {
        const bool has_corners = role == Role::faces || role == Role::strips;
        const size_t corners = has_corners ? *find_corners(element) : 0;
        if (role == Role::vertices) reserve_vertices(element.count);
        if (role == Role::faces) reserve_triangles(element, element.properties[corners]);
        size_t forgotten = at_;
        for (record_ = 0; record_ < element.count; ++record_) {
            for (size_t i = 0; i < element.properties.size(); ++i)
                read_property(element, i, role, has_corners && i == corners);
            if (role == Role::vertices) add_vertex(columns_);
            if (has_corners) add_corners(role, faces);
            if (record_ % kPiece == 0) {
                source_.forget(forgotten, at_);
                forgotten = at_;
            }
        }
    }

    void reserve_triangles(const PlyElement& element, const PlyProperty& list) {
        const uint64_t triangle_bytes = element.smallest_record_bytes() + 3 * size_of(list.type);
        const uint64_t most = std::min<uint64_t>(element.count, bytes_left() / triangle_bytes);
        result_.mesh.triangles.reserve(result_.mesh.triangles.size() + most);
    }

    void read_property(const PlyElement& element, size_t index, Role role, bool is_corners) {
        const PlyProperty& property = element.properties[index];
        if (!property.is_list) {
            const std::byte* at = take(element, size_of(property.type));
            if (role != Role::vertices) return;
            for (size_t c = 0; c < kColumns; ++c)
                if (layout_.fields[c] && layout_.fields[c]->property == index)
                    columns_[c] = load_number(property.type, at, is_swapped_);
            return;
        }
        const size_t value_bytes = size_of(property.type);
        const int64_t count =
            load_integer(property.count_type, take(element, size_of(property.count_type)), is_swapped_);
        // A count is at most 2^32, so the product is far from overflow.
        if (count < 0)
            fail(place(element) + core::text(": a list of %lld values", static_cast<long long>(count)));
        const std::byte* at = take(element, static_cast<size_t>(count) * value_bytes);
        if (!is_corners) return;
        corners_.resize(static_cast<size_t>(count));
        for (int64_t& corner : corners_) {
            corner = load_integer(property.type, at, is_swapped_);
            at += value_bytes;
        }
        // The separator of strips is -1 also where indices are unsigned.
        if (role == Role::strips && property.type == PlyType::uint32)
            std::replace(corners_.begin(), corners_.end(), int64_t{0xffffffff}, int64_t{-1});
    }

    const std::byte* take(const PlyElement& element, size_t size) {
        if (size > bytes_left())
            fail(place(element) + core::text(" of %llu: the file ends at byte %zu, %zu more are needed",
                                             static_cast<unsigned long long>(element.count),
                                             source_.bytes.size(), size - bytes_left()));
        const std::byte* at = source_.bytes.data() + at_;
        at_ += size;
        return at;
    }

    std::string place(const PlyElement& element) const {
        return core::text("%s %llu", element.name.c_str(), static_cast<unsigned long long>(record_));
    }

    const Source& source_;
    const ReadOptions& options_;
    PlyHeader header_;
    ReadResult result_;
    Layout layout_;
    std::vector<glm::dvec3> points_;  // coordinates read one by one, until the origin is known
    Columns columns_{};               // of the vertex being read
    std::vector<int64_t> corners_;    // of the face being read
    uint64_t record_ = 0;             // of the element being read
    size_t at_ = 0;                   // byte being read
    bool is_swapped_ = false;
};

}  // namespace

ReadResult read_ply(const Source& source, const ReadOptions& options) {
    return PlyReader(source, options).read();
}

}  // namespace mesh
