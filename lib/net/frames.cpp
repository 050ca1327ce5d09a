#include "net/frames.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/bytes.h"

namespace net {

std::vector<std::byte> to_frame(std::span<const std::byte> body) {
    if (body.empty() || body.size() > std::numeric_limits<uint32_t>::max())
        throw core::Error("a message to be sent is empty, or of 4 GiB or more");
    std::vector<std::byte> frame(kFrameHeaderBytes + body.size());
    const uint32_t size = uint32_t(body.size());
    std::memcpy(frame.data(), &size, sizeof size);
    std::copy(body.begin(), body.end(), frame.begin() + kFrameHeaderBytes);
    return frame;
}

void FrameReader::add(std::span<const std::byte> bytes) {
    // What was given out goes before anything is added, so that the buffer holds one frame's beginning at
    // most where next() is called until it finds nothing.
    bytes_.erase(bytes_.begin(), bytes_.begin() + std::ptrdiff_t(at_));
    at_ = 0;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::span<const std::byte> FrameReader::next() {
    const std::span<const std::byte> left = std::span(bytes_).subspan(at_);
    if (left.size() >= kFrameHeaderBytes) {
        uint32_t size = 0;
        std::memcpy(&size, left.data(), sizeof size);
        if (size == 0) throw core::Error("a message is empty");
        if (size > most_body_bytes_)
            throw core::Error(core::text("a message is said to have %u bytes, at most %zu are taken", size,
                                         most_body_bytes_));
        if (left.size() - kFrameHeaderBytes >= size) {
            at_ += kFrameHeaderBytes + size;
            return left.subspan(kFrameHeaderBytes, size);
        }
    }
    if (left.empty() && bytes_.capacity() > 0) {
        std::vector<std::byte>().swap(bytes_);
        at_ = 0;
    }
    return {};
}

}  // namespace net
