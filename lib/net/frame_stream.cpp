#include "net/frame_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "net/event_loop.h"

namespace net {

namespace {

constexpr size_t kReadBytes = 16 << 10;

bool is_no_failure() {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

FrameStream::FrameStream(core::Descriptor socket, const std::string& name, size_t most_body_bytes)
    : FrameStream(std::move(socket), core::Descriptor(), name, most_body_bytes) {}

FrameStream::FrameStream(core::Descriptor in, core::Descriptor out, const std::string& name,
                         size_t most_body_bytes)
    : in_(std::move(in)),
      out_(std::move(out)),
      name_(name),
      most_kept_bytes_(most_body_bytes + kReadBytes),
      reader_(most_body_bytes) {
    ::fcntl(in_.get(), F_SETFL, O_NONBLOCK);
    if (out_) ::fcntl(out_.get(), F_SETFL, O_NONBLOCK);
}

bool FrameStream::wait(bool to_read, bool to_write, double seconds) const {
    const int ms = int(std::clamp(std::ceil(seconds * 1000), 0.0, 3'600'000.0));
    std::array<pollfd, 2> waiting = {pollfd{to_read ? in_.get() : -1, POLLIN, 0},
                                     pollfd{to_write ? out() : -1, POLLOUT, 0}};
    return ::poll(waiting.data(), waiting.size(), ms) > 0;
}

// False where nothing is there.
bool FrameStream::read_some() {
    std::array<std::byte, kReadBytes> bytes;
    const ssize_t size = ::read(in_.get(), bytes.data(), bytes.size());
    if (size < 0 && is_no_failure()) return false;
    if (size <= 0)
        throw ConnectionLost(name_ + ": the server has ended the connection" +
                             (reader_.is_within() ? " within a message" : ""));
    bytes_received_ += uint64_t(size);
    kept_bytes_ += size_t(size);
    reader_.add(std::span(bytes).first(size_t(size)));
    return true;
}

void FrameStream::send(std::span<const std::byte> body, double timeout_s) {
    const std::vector<std::byte> frame = to_frame(body);
    const double until = steady_seconds() + timeout_s;
    for (size_t at = 0; at != frame.size();) {
        // A pipe is no socket; SIGPIPE is ignored by all programs (core/program.h).
        const ssize_t size = out_ ? ::write(out(), frame.data() + at, frame.size() - at)
                                  : ::send(out(), frame.data() + at, frame.size() - at, MSG_NOSIGNAL);
        if (size < 0 && !is_no_failure()) {
            // What it said before it ended, which may be why, is there to be received.
            if (reader_.is_within()) return;
            throw ConnectionLost(name_ + ": the server has ended the connection");
        }
        if (size > 0) {
            at += size_t(size);
            bytes_sent_ += uint64_t(size);
            continue;
        }
        // Both sides may be waiting until the other one reads.
        const bool is_reading = kept_bytes_ < most_kept_bytes_;
        if (!wait(is_reading, true, until - steady_seconds()) && steady_seconds() >= until)
            throw core::Error(name_ + ": the server does not read what it is sent");
        if (is_reading) read_some();
    }
}

std::span<const std::byte> FrameStream::receive(double timeout_s) {
    const double until = steady_seconds() + timeout_s;
    for (;;) {
        const std::span<const std::byte> body = reader_.next();
        if (!body.empty()) {
            kept_bytes_ -= kFrameHeaderBytes + body.size();
            return body;
        }
        if (read_some()) continue;
        const double left = until - steady_seconds();
        if (left <= 0) return {};
        wait(true, false, left);
    }
}

}  // namespace net
