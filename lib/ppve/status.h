// The counters of a server: what it keeps count of, and asking a server for them.
#pragma once

#include <cstdint>
#include <string>

#include "core/json.h"
#include "net/server.h"
#include "ppve/session.h"

namespace ppve {

// Of all sessions since the start.
struct SessionCounts {
    uint64_t requests = 0;          // that came
    uint64_t requests_refused = 0;  // too large, not counted up, or the sampler failed
    uint64_t requests_replaced = 0;
    uint64_t updates = 0;  // answers with an image
    uint64_t updates_anew = 0;
    EliminationCounts elimination;
    uint64_t leaves_deleted = 0, leaves_evicted = 0;
    uint64_t image_bytes = 0;
    // Of the scene as it is kept: all, and what updates have read of it, together and one at most.
    uint64_t scene_bytes = 0, scene_bytes_touched = 0, scene_bytes_touched_most = 0;
    double sample_ms = 0, eliminate_ms = 0, encode_ms = 0, insert_ms = 0;

    void add(const AnswerReport& report);
};

// What is kept now of the clients that are connected.
struct SessionMemory {
    uint64_t points = 0, bytes = 0;
    uint64_t most_points = 0;  // of one client: the limit
};

// An object with a key for each counter, as in ppve-sample(1).
core::Json status_of(const net::ServerCounts& net, const SessionCounts& sessions,
                     const SessionMemory& memory);

// What the server at `address` (of net::parse_address()) says of itself, JSON.  Throws core::Error where it
// cannot be reached, is none, or refuses.
std::string ask_status(const std::string& address, double timeout_s);

}  // namespace ppve
