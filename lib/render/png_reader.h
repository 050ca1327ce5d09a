// The PNG side of read_image(), for lib/render only.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "render/image.h"

namespace render {

// True if the bytes begin as a PNG.
bool is_png(std::span<const std::byte> bytes);

// As decode_image().
Image read_png(std::span<const std::byte> bytes, const std::string& name);

// Throws core::Error "<name>: ..." unless both sides are 1 to kMaxImageSide and the picture fits
// kMaxImageBytes.
void check_image_size(int64_t width, int64_t height, const std::string& name);

}  // namespace render
