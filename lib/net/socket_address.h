// Addresses as the system takes them.
#pragma once

#include <sys/socket.h>

#include <string>
#include <vector>

#include "net/address.h"

namespace net {

struct SocketAddress {
    sockaddr_storage storage = {};
    socklen_t size = 0;
    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

// Throws core::UsageError where the path is longer than the system's 107 bytes.
SocketAddress unix_address(const std::string& path);

// All that the host's name stands for, at least one.  `flags` are those of getaddrinfo(3).  Throws
// core::Error.
std::vector<SocketAddress> resolve(const Address& address, int flags);

// As an Address's text: what a socket is bound to.
std::string name_of(int socket);

}  // namespace net
