// A listening socket of streams: made here, or handed over by systemd.
#pragma once

#include <string>

#include "core/descriptor.h"
#include "net/address.h"

namespace net {

// The listening socket that systemd hands over (LISTEN_PID, LISTEN_FDS), empty where it does not.  Throws
// core::Error where it is not one that listens, of `type` (SOCK_STREAM, ...).  It does not block.
core::Descriptor inherited_socket(int type);

// As many open descriptors as the system lets this user have: a thousand clients need a thousand.
void allow_many_descriptors();

// Move-only.
class Listener {
  public:
    // Listens on `address`; port 0 is a free one.  A Unix socket is open to this user alone, takes the place
    // of one that nobody listens on any more, and is removed at the end.  Throws core::Error.
    explicit Listener(const Address& address);
    // Takes over a socket that listens already.
    explicit Listener(core::Descriptor socket);
    ~Listener();
    Listener(Listener&& other) noexcept = default;

    int descriptor() const { return socket_.get(); }
    // Where it listens, as parse_address() takes it: "127.0.0.1:40123", "/run/pm.socket".
    const std::string& name() const { return name_; }

  private:
    core::Descriptor socket_;
    std::string name_;
    bool is_to_be_removed_ = false;
};

}  // namespace net
