// What a server makes packets from, one after the other; so something newer can take its place after each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pm/split_data.h"

namespace pm {

struct Packet {
    uint32_t decisions = 0;
    uint16_t check = 0;  // of the splits in it
    bool is_last = false;
    std::vector<std::byte> bytes;
};

struct AnswerCounts {
    uint64_t splits = 0, cones = 0, cuts = 0, delays = 0, skips = 0;
};

class PacketSource {
  public:
    virtual ~PacketSource() = default;
    // At most so many decisions.  Throws core::Error where the model is damaged.
    virtual Packet next(uint32_t most_decisions) = 0;
    const AnswerCounts& counts() const { return counts_; }

  protected:
    AnswerCounts counts_;
};

// The check of a packet after one more split.
constexpr uint16_t mixed(uint16_t check, const VertexData& vertex) {
    const uint32_t value =
        check * 31u + vertex.position.x * 7u + vertex.position.y * 5u + vertex.position.z * 3u;
    return uint16_t(value ^ value >> 16);
}

}  // namespace pm
