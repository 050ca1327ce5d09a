// The client's end of a framed connection, for programs that wait for what they asked for.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/descriptor.h"
#include "net/frames.h"

namespace net {

// The other end has gone; what it sent before has been received.  A client may connect again.
class ConnectionLost : public core::Error {
  public:
    using core::Error::Error;
};

// Not thread-safe.
class FrameStream {
  public:
    // A socket, from connect_to(); `name` is the server, for messages.
    FrameStream(core::Descriptor socket, const std::string& name, size_t most_body_bytes);
    // Two ends of pipes: standard output and input of a program that serves one client.
    FrameStream(core::Descriptor in, core::Descriptor out, const std::string& name, size_t most_body_bytes);

    // Waits at most `timeout_s` until the system has taken all of it; what comes meanwhile is kept (up to one
    // frame's limit and 16 KiB, then it waits in the system).  Throws core::Error "<name>: ...".
    void send(std::span<const std::byte> body, double timeout_s);

    // The body of the next frame, valid until the next call; empty where none is whole within `timeout_s`.
    // Throws core::Error where a frame is not as it should be, and ConnectionLost.
    std::span<const std::byte> receive(double timeout_s);

    // Of what was sent and received, with frame headers.
    uint64_t bytes_sent() const { return bytes_sent_; }
    uint64_t bytes_received() const { return bytes_received_; }
    const std::string& name() const { return name_; }

  private:
    int out() const { return out_ ? out_.get() : in_.get(); }
    bool read_some();
    bool wait(bool to_read, bool to_write, double seconds) const;

    core::Descriptor in_, out_;  // out_ is empty where one socket is both
    std::string name_;
    size_t most_kept_bytes_, kept_bytes_ = 0;
    FrameReader reader_;
    uint64_t bytes_sent_ = 0, bytes_received_ = 0;
};

}  // namespace net
