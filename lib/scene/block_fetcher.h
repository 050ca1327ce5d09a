// Whoever brings the blocks of models that are arriving.
#pragma once

#include <cstdint>
#include <span>

#include "scene/request_order.h"

namespace scene {

class BlockFetcher {
  public:
    virtual ~BlockFetcher() = default;

    // Takes the place of all that was asked for before.  Models by their places among those that are drawn.
    virtual void ask(std::span<const BlockRequest> requests) = 0;

    // Waits until something of what was last asked for has come, which it says once: ask again for the rest.
    // False where nothing has in this time.  Throws core::Error where what was asked for cannot be had, with
    // the reason.
    virtual bool wait(double timeout_s) = 0;
    // A file was replaced by another version: what is there stays, and nothing more comes.
    virtual bool has_ended() const = 0;
    // At most so much comes over the network until the block is there, if nothing has to be sent again.
    virtual uint64_t most_bytes(const BlockRequest& request) const = 0;

    struct Counters {
        uint64_t bytes = 0, requests = 0;  // of the network, since the models were opened, that included
        double round_trip_s = 0;           // 0: not known
        double bytes_per_s = 0;            // that the link carries, as far as that is known
        uint64_t window_bytes = 0;         // that are in flight where enough is asked for; 0: not known
    };
    virtual Counters counters() = 0;
};

}  // namespace scene
