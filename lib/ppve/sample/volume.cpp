#include "ppve/sample/volume.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>

#include "core/error.h"

namespace ppve {

namespace {

constexpr size_t kMostHeaderBytes = 65536;
constexpr double kMostSpacing = 1e30, kLeastSpacing = 1e-30;

uint64_t size_of(VoxelType type) {
    constexpr uint64_t kSizes[] = {1, 1, 2, 2, 4, 4, 4};
    return kSizes[size_t(type)];
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlank = " \t\r";
    const size_t first = text.find_first_not_of(kBlank);
    return first == std::string_view::npos ? ""
                                           : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

using Keys = std::map<std::string, std::string, std::less<>>;

Keys keys_of(std::string_view text, const std::string& name) {
    Keys keys;
    for (int line = 1; !text.empty(); ++line) {
        const size_t end = text.find('\n');
        const std::string_view now = trimmed(text.substr(0, end));
        text = end == std::string_view::npos ? "" : text.substr(end + 1);
        if (now.empty()) continue;
        const size_t equals = now.find('=');
        if (equals == std::string_view::npos)
            throw core::Error(core::text("%s: line %d: expected KEY = VALUE", name.c_str(), line));
        keys[std::string(trimmed(now.substr(0, equals)))] = trimmed(now.substr(equals + 1));
    }
    return keys;
}

// As many numbers as `out` has, with blanks between, and nothing else.
template <class T>
bool read_numbers(std::string_view text, std::span<T> out) {
    for (T& number : out) {
        text = trimmed(text);
        const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (fault != std::errc()) return false;
        text = text.substr(size_t(end - text.data()));
    }
    return trimmed(text).empty();
}

VoxelType type_of(const std::string& word, const std::string& name) {
    static const std::map<std::string, VoxelType> kTypes = {
        {"MET_CHAR", VoxelType::int8},     {"MET_UCHAR", VoxelType::uint8}, {"MET_SHORT", VoxelType::int16},
        {"MET_USHORT", VoxelType::uint16}, {"MET_INT", VoxelType::int32},   {"MET_UINT", VoxelType::uint32},
        {"MET_FLOAT", VoxelType::float32}};
    const auto found = kTypes.find(word);
    if (found == kTypes.end()) throw core::Error(name + ": ElementType: samples of this type are not read");
    return found->second;
}

bool is_plain_name(const std::string& file) {
    return !file.empty() && file != "LOCAL" && file != "LIST" && file != "." && file != ".." &&
           file.find('/') == std::string::npos && file.find('%') == std::string::npos;
}

}  // namespace

uint64_t VolumeHeader::bytes() const {
    return samples() * size_of(type);
}

bool is_volume_header(std::string_view text) {
    const std::string_view head = text.substr(0, kMostHeaderBytes);
    return head.find("NDims") != std::string_view::npos &&
           head.find("ElementType") != std::string_view::npos &&
           head.find("ElementDataFile") != std::string_view::npos;
}

VolumeHeader parse_volume_header(std::string_view text, const std::string& name) {
    if (text.size() > kMostHeaderBytes) throw core::Error(name + ": too long for the header of a volume");
    const Keys keys = keys_of(text, name);
    const auto value = [&](std::string_view key, const char* otherwise) {
        const auto found = keys.find(key);
        return found == keys.end() ? std::string(otherwise) : found->second;
    };
    const auto fail = [&](const std::string& what) { throw core::Error(name + ": " + what); };
    if (value("NDims", "") != "3") fail("NDims: not a volume of 3 dimensions");
    for (const char* key : {"BinaryDataByteOrderMSB", "ElementByteOrderMSB", "CompressedData"})
        if (value(key, "False") != "False")
            fail(std::string(key) + ": only plain little-endian samples are read");
    if (value("ElementNumberOfChannels", "1") != "1") fail("ElementNumberOfChannels: only one is read");
    double axes[9];
    constexpr double kStraight[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (const char* key : {"TransformMatrix", "Rotation", "Orientation"})
        if (!read_numbers<double>(value(key, "1 0 0 0 1 0 0 0 1"), axes) ||
            !std::equal(axes, axes + 9, kStraight))
            fail(std::string(key) + ": turned axes are not read");
    VolumeHeader h;
    int size[3];
    if (!read_numbers<int>(value("DimSize", ""), size)) fail("DimSize: three whole numbers are needed");
    double spacing[3], offset[3];
    if (!read_numbers<double>(value("ElementSpacing", value("ElementSize", "1 1 1").c_str()), spacing))
        fail("ElementSpacing: three numbers are needed");
    if (!read_numbers<double>(value("Offset", value("Position", "0 0 0").c_str()), offset))
        fail("Offset: three numbers are needed");
    for (int k = 0; k < 3; ++k) {
        if (size[k] < 2 || size[k] > VolumeHeader::kMostSamples)
            fail(core::text("DimSize: %d samples; 2 to %d are right", size[k], VolumeHeader::kMostSamples));
        if (!(spacing[k] >= kLeastSpacing && spacing[k] <= kMostSpacing))
            fail("ElementSpacing: out of range");
        if (!(std::abs(offset[k]) <= kMostSpacing)) fail("Offset: out of range");
        h.size[k] = size[k], h.spacing[k] = spacing[k], h.offset[k] = offset[k];
    }
    h.type = type_of(value("ElementType", ""), name);
    h.data_file = value("ElementDataFile", "");
    if (!is_plain_name(h.data_file)) fail("ElementDataFile: the name of a file beside the header is needed");
    return h;
}

Volume::Volume(const std::string& path) {
    const core::InputFile head(path);
    const auto bytes = head.bytes();
    header_ = parse_volume_header({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, head.name());
    const size_t slash = path.rfind('/');
    data_.emplace((slash == std::string::npos ? "" : path.substr(0, slash + 1)) + header_.data_file);
    if (data_->bytes().size() != header_.bytes())
        throw core::Error(core::text("%s: %zu bytes, %s says %llu", data_->name().c_str(),
                                     data_->bytes().size(), head.name().c_str(),
                                     static_cast<unsigned long long>(header_.bytes())));
}

float Volume::at(int x, int y, int z) const {
    const size_t n = (size_t(z) * size_t(header_.size.y) + size_t(y)) * size_t(header_.size.x) + size_t(x);
    const auto take = [&]<class T>(T value) {
        std::memcpy(&value, data_->bytes().data() + n * sizeof(T), sizeof(T));
        return float(value);
    };
    switch (header_.type) {
        case VoxelType::int8:
            return take(int8_t());
        case VoxelType::uint8:
            return take(uint8_t());
        case VoxelType::int16:
            return take(int16_t());
        case VoxelType::uint16:
            return take(uint16_t());
        case VoxelType::int32:
            return take(int32_t());
        case VoxelType::uint32:
            return take(uint32_t());
        case VoxelType::float32:
            break;
    }
    const float value = take(0.0f);
    return std::isfinite(value) ? value : std::numeric_limits<float>::lowest();
}

}  // namespace ppve
