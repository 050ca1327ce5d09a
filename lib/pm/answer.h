// How a server answers a view: the splits that it wants and that were not sent, the largest error on the
// screen first, in packets of any size; so a new view can take its place after each.
#pragma once

#include <unordered_map>
#include <vector>

#include "pm/packet_source.h"
#include "pm/served_model.h"
#include "pm/sweep.h"

namespace pm {

class Answer final : public PacketSource {
  public:
    // All of them outlive it.
    Answer(const ServedModel& served, SentRecord& record, ServedReplica& replica, const View& view,
           Culling culling = Culling::on);

    Packet next(uint32_t most_decisions) override;

  private:
    Verdict verdict(uint32_t detail) const { return sweep_.verdict(served_.model().bounds(detail)); }
    bool is_wanted(uint32_t detail);
    bool is_parent_wanted(const Node& node) const;
    void decide(RangeEncoder& encoder, uint32_t node, uint16_t& check);
    void send_split(RangeEncoder& encoder, uint32_t node, uint16_t& check);
    bool send_cuts(RangeEncoder& encoder, uint32_t node);
    bool send_cone(RangeEncoder& encoder, uint32_t node);
    bool find_cone(uint32_t node, std::vector<bool>& way, uint32_t& found) const;

    const ServedModel& served_;
    SentRecord& record_;
    ServedReplica& replica_;
    Sweep sweep_;
    std::vector<uint8_t> wanted_;                        // by split: with the model's cones
    std::unordered_map<uint32_t, bool> is_wanted_;       // by detail that was asked for by name
    std::unordered_map<uint32_t, uint32_t> delayed_at_;  // by node: splits that were sent when it was put off
    Ring ring_;
};

// The same on the client's side: tells the replica what a packet says.  Throws core::Error where it is wrong.
void take_packet(Replica& replica, SplitModels& models, Sweep& sweep, uint32_t decisions, uint16_t check,
                 std::span<const std::byte> bytes);

}  // namespace pm
