// Lists of nodes that a client wants split, and the answers to them.
//
// Kim, Lee, Kobbelt, section 6.3: the client sends what is to be split and not what it looks at, so that the
// server tests nothing.  What it costs: a client knows the children of a split when it has come, and asks for
// them in the next list, one round trip a level of the tree; and it knows no cones.
#pragma once

#include <span>
#include <vector>

#include "pm/packet_source.h"
#include "pm/replica.h"
#include "pm/sent_tree.h"
#include "pm/sweep.h"

namespace pm {

// The nodes that the sweep comes to next, at most so many; as they are asked for, in the order of the tree.
struct NodeList {
    std::vector<uint32_t> nodes;
    std::vector<std::byte> bytes;
};
NodeList make_list(const Replica& replica, SplitModels& models, Sweep<Replica>& sweep, size_t most);

// The details that a list asks for, in the order of the tree.  Throws core::Error where it is none.
std::vector<uint32_t> read_list(const ServedModel& served, SentRecord& record,
                                std::span<const std::byte> bytes);

class ListAnswer final : public PacketSource {
  public:
    // Both outlive it.  The details from the first one on that was not answered.
    ListAnswer(const ServedModel& served, SentRecord& record, std::span<const uint32_t> details);
    // Throws core::Error where a split was asked for that cannot be done though the client could know it.
    Packet next(uint32_t most_decisions) override;

  private:
    void answer(RangeEncoder& encoder, uint32_t node, uint16_t& check);

    const ServedModel& served_;
    SentRecord& record_;
    SentTree tree_;
    std::vector<uint32_t> nodes_;
    size_t answered_ = 0;
};

// The client's side: answers to the nodes of its list from the first on.
void take_list_packet(Replica& replica, SplitModels& models, std::span<const uint32_t> nodes, uint16_t check,
                      std::span<const std::byte> bytes);

}  // namespace pm
