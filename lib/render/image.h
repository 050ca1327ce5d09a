// Frames into files and streams, and pictures back: PNG, PPM, y4m, raw rgb, PFM.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/frame.h"

namespace render {

// An 8-bit RGB picture, row 0 on top, rows without padding.
struct Image {
    int width = 0, height = 0;
    std::vector<uint8_t> rgb;
};

// Pictures larger than this are neither read nor written.
constexpr int kMaxImageSide = 65535;
constexpr uint64_t kMaxImageBytes = uint64_t(1) << 30;  // of 3 bytes a pixel

enum class ImageFormat { png, ppm, y4m, rgb };

// By the name's extension, in either case; "-" is y4m.  Throws core::UsageError for an unknown extension.
ImageFormat format_of_name(const std::string& name);

// `rgb`: 3 * width * height bytes, 1 x 1 at least.  Throw core::Error beyond the limits above.
//
// PNG of `channels` bytes a pixel, 3 or (alpha last) 4, by the Up filter and libdeflate level 1 (11 to 14 ms
// at 1280x720, where libpng takes 126).  Keeps about 6 bytes a pixel of scratch memory for each thread that
// called it.
std::vector<std::byte> encode_png(const uint8_t* pixels, int width, int height, int channels = 3);
std::vector<std::byte> encode_ppm(const uint8_t* rgb, int width, int height);
// Little-endian PFM, one channel, rows bottom to top as the format has them; background is inf.
std::vector<std::byte> encode_pfm(const float* values, int width, int height);

// PNG (any colour type and depth, by libpng, to 8-bit RGB over black, gamma left alone) or binary PPM of 8
// bits; told by the content.  "-" is standard input.  Throws core::Error; sizes are checked against the
// limits above and against the bytes that are there before memory is taken.
Image read_image(const std::string& path);

// The same from bytes; `name` is for messages.
Image decode_image(std::span<const std::byte> bytes, const std::string& name);

// Writes a sequence.  `name` with a printf-like "%04d" (frame_name()) is a file a frame, renamed into place
// when whole; any other name is one file, and "-" a stream.  One file holds frames one after the other: y4m
// with one header, ppm and rgb as they are, png to "-" only (a second frame into one PNG file is an
// error).  Encoding and writing run on core::thread_count() worker threads (at most 16) behind the
// renderer, in order, at most a few frames deep; the bytes do not depend on how many there are.
//
// One thread calls.  A failure of a worker is thrown by the next write() or by finish(), as it was
// thrown there; nothing is written after it.  Destroyed without finish(), a file under construction is left
// out.
class FrameWriter {
  public:
    // `frames_per_s`: above 0, at most 1000; only y4m has a place for it.  Throws core::UsageError for
    // a rate out of range and for a name that frame_name() refuses.
    FrameWriter(std::string name, ImageFormat format, double frames_per_s);
    ~FrameWriter();
    // Copies what it needs.  All frames of one stream have one size, and only PNG takes an alpha
    // (core::Error). `eye`: as in frame_name().
    void write(int frame_number, const Frame& frame, const std::string& eye = "");
    // The depth as PFM, a file a frame, named as above; "-" is a stream of them.
    void write_depth(const std::string& name, int frame_number, const Frame& frame,
                     const std::string& eye = "");
    void finish();  // waits, commits; throws the first failure

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// Name of one frame's file: %d or %0Nd (N from 1 to 9) becomes the number, %s the eye, %% a percent sign.
// Throws core::UsageError for any other %, for a second number and for a second eye.
std::string frame_name(const std::string& name, int frame_number, const std::string& eye = "");

// True if `name` has a place for the frame's number.  Throws as frame_name().
bool has_frame_number(const std::string& name);

// True if `name` has a place for the eye.  Throws as frame_name().
bool has_eye(const std::string& name);

}  // namespace render
