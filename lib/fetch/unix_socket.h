// The daemon's socket in its folder, and messages with descriptors over it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fetch/descriptor.h"

namespace fetch {

// Both name the socket by the folder's descriptor, so that the folder's path may be of any length.
// Throws core::Error; a socket that is there is replaced, so the caller must hold the folder's lock.
Descriptor listen_in(int folder, const std::string& path);
// Empty where nobody listens.  Throws core::Error for any other reason.
Descriptor connect_to(int folder, const std::string& path);

// The user at the other end.
unsigned peer_of(int socket);

// One message, whole or not at all.  False where the socket takes none now; throws core::Error where the
// other end has gone.
bool send_message(int socket, std::span<const std::byte> message, std::span<const int> descriptors);

struct Received {
    bool is_closed = false;  // the other end has gone
    std::vector<std::byte> message;
    std::vector<Descriptor> descriptors;
};
// The next message, without waiting; false where there is none.  Throws core::Error for one that is longer
// than kMostMessageBytes.  At most `most_descriptors` are taken, others are closed by the system.
bool receive_message(int socket, size_t most_descriptors, Received& received);

}  // namespace fetch
