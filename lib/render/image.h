// Frames into files and streams, and pictures back: PNG, PPM, y4m, raw rgb, PFM.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/frame.h"

namespace render {

// An 8-bit RGB picture, row 0 on top.
struct Image {
    int width = 0, height = 0;
    std::vector<uint8_t> rgb;
};

enum class ImageFormat { png, ppm, y4m, rgb };

// By the name's extension; "-" is y4m.  Throws core::UsageError for an unknown extension.
ImageFormat format_of_name(const std::string& name);

// PNG by the Up filter and libdeflate level 1 (11 to 14 ms at 1280x720, where libpng takes 126).
std::vector<std::byte> encode_png(const uint8_t* rgb, int width, int height);
std::vector<std::byte> encode_ppm(const uint8_t* rgb, int width, int height);
// Little-endian PFM, one channel, rows bottom to top as the format has them; background is inf.
std::vector<std::byte> encode_pfm(const float* values, int width, int height);

// PNG (any colour type, by libpng, to 8-bit RGB over black) or binary PPM.  Throws core::Error; sizes are
// checked before memory is taken (at most 65535 x 65535 and 1 GiB).
Image read_image(const std::string& path);

// Writes a sequence.  `name` with a printf-like "%04d" (one integer conversion, %d or %0Nd) is a file
// a frame, renamed into place when whole; any other name is one file, and "-" a stream.  Encoding and writing run
// on worker threads behind the renderer, in order, at most a few frames deep.
class FrameWriter {
  public:
    FrameWriter(std::string name, ImageFormat format, double frames_per_s);
    ~FrameWriter();
    void write(int frame_number, const Frame& frame);  // copies what it needs
    void write_depth(const std::string& name, int frame_number, const Frame& frame);
    void finish();  // waits, commits; throws the first failure

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// Name of one frame's file from a template; the template itself where it has no conversion.
std::string frame_name(const std::string& name, int frame_number);

}  // namespace render
