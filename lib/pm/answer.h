// How a server answers a view: the splits that it wants and that were not sent, the largest error on the
// screen first, in packets of any size; so a new view can take its place after each.
#pragma once

#include <unordered_map>
#include <vector>

#include "pm/packet_source.h"
#include "pm/replica.h"
#include "pm/sent_tree.h"
#include "pm/sweep.h"

namespace pm {

class Answer final : public PacketSource {
  public:
    // Both outlive it.
    Answer(const ServedModel& served, SentRecord& record, const View& view, Culling culling = Culling::on);

    Packet next(uint32_t most_decisions) override;

  private:
    Verdict verdict(uint32_t node) const { return sweep_.verdict(served_.bounds(node)); }
    bool is_wanted(uint32_t node);
    bool is_parent_wanted(uint32_t node) const;
    void decide(RangeEncoder& encoder, uint32_t node, uint16_t& check);
    bool send_cone(RangeEncoder& encoder, uint32_t node);
    bool find_cone(uint32_t node, std::vector<bool>& way, uint32_t& found) const;

    const ServedModel& served_;
    Hierarchy hierarchy_;
    SentRecord& record_;
    SentTree tree_;
    Sweep<SentTree> sweep_;
    std::vector<bool> wanted_;                           // by node that is split: with the model's cones
    std::unordered_map<uint32_t, bool> is_wanted_;       // by node that was asked for by name
    std::unordered_map<uint32_t, uint32_t> delayed_at_;  // by node: splits that were sent when it was put off
};

// The same on the client's side: tells the replica what a packet says.  Throws core::Error where it is wrong.
void take_packet(Replica& replica, SplitModels& models, Sweep<Replica>& sweep, uint32_t decisions,
                 uint16_t check, std::span<const std::byte> bytes);

}  // namespace pm
