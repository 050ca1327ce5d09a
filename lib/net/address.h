// Where a server of streams listens and its clients connect: TCP, or a Unix socket.
#pragma once

#include <cstdint>
#include <string>

#include "core/descriptor.h"

namespace net {

// "HOST:PORT" ([::1]:4100 for IPv6, :4100 for loopback), or the path of a Unix socket, which has a '/' in it
// ("unix:" may stand before it).
struct Address {
    std::string host;  // empty for a Unix socket
    uint16_t port = 0;
    std::string path;

    bool is_unix() const { return host.empty(); }
};

// Throws core::UsageError with what is wrong and how it should look.
Address parse_address(const std::string& text);
std::string to_text(const Address& address);

// Nobody answers there; later somebody may.
class CannotConnect : public core::Error {
  public:
    using core::Error::Error;
};

// Waits at most `timeout_s`.  The socket does not block.  Throws CannotConnect "<address>: cannot connect:
// ...".
core::Descriptor connect_to(const Address& address, double timeout_s);

}  // namespace net
