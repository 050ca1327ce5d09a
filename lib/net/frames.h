// Messages on a stream of bytes.  A frame is the length of its body (32 bits, little-endian, these four bytes
// not counted) and the body, of at least one byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace net {

constexpr size_t kFrameHeaderBytes = 4;

// Throws core::Error for an empty body, and for one of 4 GiB or more.
std::vector<std::byte> to_frame(std::span<const std::byte> body);

// Puts frames together from the bytes of a stream as they come.  Takes no more memory than twice what has
// come of a frame and was not yet asked for, and none between frames.
class FrameReader {
  public:
    explicit FrameReader(size_t most_body_bytes) : most_body_bytes_(most_body_bytes) {}

    // Appends what has come.
    void add(std::span<const std::byte> bytes);

    // The body of the next whole frame, valid until the next call of either function; empty where none is
    // whole. Throws core::Error as soon as a length is known to be 0 or beyond the limit.
    std::span<const std::byte> next();

    // Some bytes of a frame that is not whole have come, or whole ones that next() was not asked for.
    bool is_within() const { return at_ < bytes_.size(); }

  private:
    size_t most_body_bytes_;
    std::vector<std::byte> bytes_;
    size_t at_ = 0;  // what lies before was given out
};

}  // namespace net
