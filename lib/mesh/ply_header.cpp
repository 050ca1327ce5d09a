#include "mesh/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "mesh/text.h"

namespace mesh {

namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{{
    {"char", PlyType::int8},
    {"int8", PlyType::int8},
    {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},
    {"short", PlyType::int16},
    {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},
    {"uint16", PlyType::uint16},
    {"int", PlyType::int32},
    {"int32", PlyType::int32},
    {"uint", PlyType::uint32},
    {"uint32", PlyType::uint32},
    {"float", PlyType::float32},
    {"float32", PlyType::float32},
    {"double", PlyType::float64},
    {"float64", PlyType::float64},
}};

constexpr std::array<std::pair<std::string_view, PlyForm>, 3> kFormNames{{
    {"ascii", PlyForm::ascii},
    {"binary_little_endian", PlyForm::little_endian},
    {"binary_big_endian", PlyForm::big_endian},
}};

// Takes one line of the header at a time.
class HeaderReader {
  public:
    explicit HeaderReader(const Source& source) : text_(source, 0, 0) {}

    PlyHeader read() {
        if (text_.word_in_line() != "ply") text_.fail("a PLY file begins with 'ply'");
        bool has_form = false;
        for (;;) {
            end_line();
            if (!text_.next_line()) text_.fail("the file ends inside the header");
            const std::string_view keyword = text_.word_in_line();
            if (keyword == "end_header") break;
            if (keyword == "format") {
                has_form = true;
                read_form();
            } else if (keyword == "element") {
                read_element();
            } else if (keyword == "property") {
                read_property();
            } else if (keyword == "comment" || keyword == "obj_info") {
                while (!text_.word_in_line().empty()) continue;
            } else if (!keyword.empty()) {
                text_.fail(quoted(keyword) + " is not a keyword of a PLY header");
            }
        }
        if (!has_form) text_.fail("the header ends without a format line");
        end_line();
        text_.next_line();
        header_.body = text_.position();
        return std::move(header_);
    }

  private:
    std::string_view expect(const char* what) {
        const std::string_view word = text_.word_in_line();
        if (word.empty()) text_.fail(std::string("the header's line ends where ") + what + " is expected");
        return word;
    }

    void end_line() {
        const std::string_view extra = text_.word_in_line();
        if (!extra.empty()) text_.fail(quoted(extra) + " stands after the end of the header's line");
    }

    void read_form() {
        const std::string_view name = expect("a format");
        const auto found = std::find_if(kFormNames.begin(), kFormNames.end(),
                                        [&](const auto& entry) { return entry.first == name; });
        if (found == kFormNames.end()) text_.fail(quoted(name) + " is not a PLY format");
        header_.form = found->second;
        const std::string_view version = expect("a version");
        if (version != "1.0") text_.fail("PLY version " + quoted(version) + ", only 1.0 is known");
    }

    void read_element() {
        PlyElement element;
        element.name = expect("an element's name");
        const std::string_view count = expect("an element's count");
        const int64_t value = text_.integer(count);
        if (value < 0) text_.fail("element " + quoted(element.name) + " has the count " + quoted(count));
        element.count = static_cast<uint64_t>(value);
        header_.elements.push_back(std::move(element));
    }

    PlyType type_named(std::string_view name) {
        const auto found = std::find_if(kTypeNames.begin(), kTypeNames.end(),
                                        [&](const auto& entry) { return entry.first == name; });
        if (found == kTypeNames.end()) text_.fail(quoted(name) + " is not a PLY type");
        return found->second;
    }

    void read_property() {
        if (header_.elements.empty()) text_.fail("a property stands before the first element");
        PlyProperty property;
        std::string_view type = expect("a type");
        if (type == "list") {
            property.is_list = true;
            property.count_type = type_named(expect("a type"));
            if (is_float(property.count_type)) text_.fail("a list's count is not of an integer type");
            type = expect("a type");
        }
        property.type = type_named(type);
        property.name = expect("a property's name");
        header_.elements.back().properties.push_back(std::move(property));
    }

    TextReader text_;
    PlyHeader header_;
};

}  // namespace

size_t size_of(PlyType type) {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8:
            return 1;
        case PlyType::int16:
        case PlyType::uint16:
            return 2;
        case PlyType::float64:
            return 8;
        default:
            return 4;
    }
}

bool is_float(PlyType type) {
    return type == PlyType::float32 || type == PlyType::float64;
}

bool PlyElement::has_list() const {
    return std::any_of(properties.begin(), properties.end(), [](const auto& p) { return p.is_list; });
}

uint64_t PlyElement::smallest_record_bytes() const {
    uint64_t bytes = 0;
    for (const PlyProperty& p : properties) bytes += size_of(p.is_list ? p.count_type : p.type);
    return bytes;
}

const char* PlyHeader::form_name() const {
    const auto found = std::find_if(kFormNames.begin(), kFormNames.end(),
                                    [&](const auto& entry) { return entry.second == form; });
    return found->first.data();
}

PlyHeader read_ply_header(const Source& source) {
    return HeaderReader(source).read();
}

}  // namespace mesh
