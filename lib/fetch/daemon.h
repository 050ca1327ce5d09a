// The daemon: one event loop that serves the blocks of files at HTTP servers to clients on this machine.
//
// Clients of the same user connect to a Unix socket in the cache's folder and speak messages.h.  A client
// that sends anything else, that has more than kMostStreams files open, or that does not read what it is
// sent, is dropped; that is seen by no other client.  A client whose process ends is gone in the same moment.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "fetch/downloads.h"
#include "fetch/transport.h"

namespace fetch {

constexpr size_t kMostStreams = 64;  // of a client

struct DaemonOptions {
    std::string folder;                        // of the cache
    uint64_t limit_bytes = uint64_t{8} << 30;  // of disk space
    size_t most_clients = 4096;
    DownloadOptions downloads;
    double idle_exit_s = 0;  // without a client, after which it ends; 0: never
    TransportOptions transport;
};

// Holds the cache's folder from its making on.  Throws core::Error where that or the socket is not to be had.
class Daemon {
  public:
    explicit Daemon(const DaemonOptions& options);
    ~Daemon();

    // Until SIGTERM, SIGINT, a client's "stop", or idle_exit_s.
    void run();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace fetch
