// A volume of samples on a grid, mapped: MetaImage, a text header (.mhd) and raw data.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/file.h"

namespace ppve {

enum class VoxelType : uint8_t { int8, uint8, int16, uint16, int32, uint32, float32 };

// What a header says.
struct VolumeHeader {
    glm::ivec3 size{0};     // samples, 2 to kMostSamples along each axis
    glm::dvec3 spacing{1};  // world units, > 0
    glm::dvec3 offset{0};   // of the first sample
    VoxelType type = VoxelType::int16;
    std::string data_file;  // a plain name, in the header's folder

    static constexpr int kMostSamples = 65536;
    uint64_t samples() const { return uint64_t(size.x) * uint64_t(size.y) * uint64_t(size.z); }
    uint64_t bytes() const;
};

// Whether a text is such a header; the rest is up to parse_volume_header().
bool is_volume_header(std::string_view text);

// Throws core::Error "<name>: ...": no grid of three dimensions, compressed or big-endian data, turned axes,
// numbers out of range, a data file that is elsewhere.
VolumeHeader parse_volume_header(std::string_view text, const std::string& name);

class Volume {
  public:
    // Throws core::Error, also where the data file is not as long as the header says.
    explicit Volume(const std::string& path);

    const VolumeHeader& header() const { return header_; }
    // Sample (x, y, z), x fastest; in range.  A value that is not finite counts as the least.
    float at(int x, int y, int z) const;

  private:
    VolumeHeader header_;
    std::optional<core::InputFile> data_;
};

}  // namespace ppve
