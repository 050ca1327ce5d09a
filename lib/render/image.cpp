#include "render/image.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "core/error.h"
#include "core/file.h"
#include "render/png_reader.h"

namespace render {
namespace {

using core::Error;
using core::text;
using core::UsageError;

std::vector<std::byte> with_header(const std::string& header, size_t payload) {
    std::vector<std::byte> out(header.size() + payload);
    std::memcpy(out.data(), header.data(), header.size());
    return out;
}

// A PPM header's numbers: decimal, after white space and comments.
class PpmHeader {
  public:
    PpmHeader(std::span<const std::byte> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

    int take_number(const char* what) {
        skip_space();
        const char* begin = at(position_);
        const char* end = at(bytes_.size());
        int value = 0;
        const auto [stop, error] = std::from_chars(begin, end, value);
        if (error != std::errc() || *begin == '-')
            throw Error(text("%s: byte %zu: the PPM header has no %s here", name_.c_str(), position_, what));
        position_ += static_cast<size_t>(stop - begin);
        return value;
    }
    // Exactly one white space separates the header from the pixels.
    size_t pixels_begin() {
        if (position_ == bytes_.size() || !is_space(*at(position_)))
            throw Error(text("%s: byte %zu: the PPM header does not end here", name_.c_str(), position_));
        return position_ + 1;
    }

  private:
    static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
    const char* at(size_t i) const { return reinterpret_cast<const char*>(bytes_.data()) + i; }
    void skip_space() {
        while (position_ < bytes_.size() && (is_space(*at(position_)) || *at(position_) == '#')) {
            if (*at(position_) == '#')
                while (position_ < bytes_.size() && *at(position_) != '\n') ++position_;
            else
                ++position_;
        }
    }

    std::span<const std::byte> bytes_;
    std::string name_;
    size_t position_ = 2;  // behind the magic "P6"
};

bool is_ppm(std::span<const std::byte> bytes) {
    return bytes.size() >= 2 && bytes[0] == std::byte('P') && bytes[1] == std::byte('6');
}

Image read_ppm(std::span<const std::byte> bytes, const std::string& name) {
    PpmHeader header(bytes, name);
    Image image;
    image.width = header.take_number("width");
    image.height = header.take_number("height");
    const int largest = header.take_number("largest value");
    if (largest != 255)
        throw Error(text("%s: PPM with values up to %d, only 255 is read", name.c_str(), largest));
    check_image_size(image.width, image.height, name);
    const size_t size = 3 * static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    const size_t begin = header.pixels_begin();
    if (bytes.size() - begin != size)
        throw Error(text("%s: %d x %d pixels need %zu bytes, the file has %zu", name.c_str(), image.width,
                         image.height, size, bytes.size() - begin));
    image.rgb.resize(size);
    std::memcpy(image.rgb.data(), bytes.data() + begin, size);
    return image;
}

// A place in a file name, the bytes [begin, end): for the eye, or for the number, filled with zeros to
// `digits`.
struct Conversion {
    size_t begin = 0, end = 0;
    int digits = 1;
    bool is_eye = false;
};

// The conversion at `percent`: %d, %0Nd or %s.
Conversion parse_conversion(const std::string& name, size_t percent) {
    Conversion conversion{percent, percent + 2, 1};
    const std::string_view rest = std::string_view(name).substr(percent + 1);
    conversion.is_eye = rest.starts_with('s');
    if (rest.starts_with('d') || conversion.is_eye) return conversion;
    if (rest.size() >= 3 && rest[0] == '0' && rest[1] >= '1' && rest[1] <= '9' && rest[2] == 'd') {
        conversion.end = percent + 4;
        conversion.digits = rest[1] - '0';
        return conversion;
    }
    throw UsageError(
        text("'%s': a %% in a file name is %%d or %%0Nd for the frame's number, %%s for the eye, or %%%% for "
             "itself",
             name.c_str()));
}

// `name` with number and eye put in, and whether there was a place for each.
struct ExpandedName {
    std::string text;
    bool has_number = false, has_eye = false;
};

ExpandedName expand_name(const std::string& name, int frame_number, const std::string& eye) {
    ExpandedName out;
    for (size_t i = 0; i < name.size();) {
        if (name[i] != '%') {
            out.text += name[i++];
        } else if (name.compare(i, 2, "%%") == 0) {
            out.text += '%';
            i += 2;
        } else {
            const Conversion conversion = parse_conversion(name, i);
            bool& has = conversion.is_eye ? out.has_eye : out.has_number;
            if (has)
                throw UsageError(text("'%s': the name has two places for the %s", name.c_str(),
                                      conversion.is_eye ? "eye" : "frame's number"));
            has = true;
            out.text += conversion.is_eye ? eye : text("%0*d", conversion.digits, frame_number);
            i = conversion.end;
        }
    }
    return out;
}

std::string extension_of(const std::string& name) {
    const size_t slash = name.rfind('/');
    const size_t dot = name.rfind('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
    std::string extension = name.substr(dot + 1);
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

}  // namespace

void check_image_size(int64_t width, int64_t height, const std::string& name) {
    if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
        throw Error(text("%s: %lld x %lld pixels, each side must be 1 to %d", name.c_str(),
                         static_cast<long long>(width), static_cast<long long>(height), kMaxImageSide));
    const uint64_t size = 3 * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
    if (size > kMaxImageBytes)
        throw Error(text("%s: %lld x %lld pixels take %llu bytes, at most %llu are handled", name.c_str(),
                         static_cast<long long>(width), static_cast<long long>(height),
                         static_cast<unsigned long long>(size),
                         static_cast<unsigned long long>(kMaxImageBytes)));
}

ImageFormat format_of_name(const std::string& name) {
    if (name == "-") return ImageFormat::y4m;
    const std::string extension = extension_of(name);
    if (extension == "png") return ImageFormat::png;
    if (extension == "ppm") return ImageFormat::ppm;
    if (extension == "y4m") return ImageFormat::y4m;
    if (extension == "rgb") return ImageFormat::rgb;
    throw UsageError(text("'%s': unknown picture format '%s'; known are png, ppm, y4m and rgb", name.c_str(),
                          extension.c_str()));
}

std::vector<std::byte> encode_ppm(const uint8_t* rgb, int width, int height) {
    check_image_size(width, height, "ppm");
    const size_t size = 3 * static_cast<size_t>(width) * static_cast<size_t>(height);
    std::vector<std::byte> out = with_header(text("P6\n%d %d\n255\n", width, height), size);
    std::memcpy(out.data() + out.size() - size, rgb, size);
    return out;
}

std::vector<std::byte> encode_pfm(const float* values, int width, int height) {
    check_image_size(width, height, "pfm");
    const size_t row_bytes = sizeof(float) * static_cast<size_t>(width), rows = static_cast<size_t>(height);
    // The scale's sign says little-endian.
    std::vector<std::byte> out = with_header(text("Pf\n%d %d\n-1.0\n", width, height), row_bytes * rows);
    std::byte* at = out.data() + out.size() - row_bytes * rows;
    for (size_t row = rows; row-- > 0; at += row_bytes)
        std::memcpy(at, values + row * static_cast<size_t>(width), row_bytes);
    return out;
}

Image decode_image(std::span<const std::byte> bytes, const std::string& name) {
    if (is_png(bytes)) return read_png(bytes, name);
    if (is_ppm(bytes)) return read_ppm(bytes, name);
    throw Error(text("%s: neither PNG nor binary PPM (P6)", name.c_str()));
}

Image read_image(const std::string& path) {
    const core::InputFile file(path);
    return decode_image(file.bytes(), file.name());
}

std::string frame_name(const std::string& name, int frame_number, const std::string& eye) {
    return expand_name(name, frame_number, eye).text;
}

bool has_frame_number(const std::string& name) {
    return expand_name(name, 0, "").has_number;
}

bool has_eye(const std::string& name) {
    return expand_name(name, 0, "").has_eye;
}

}  // namespace render
