// A client's side of splits in packets.
#pragma once

#include "pm/packet_source.h"
#include "pm/replica.h"

namespace pm {

class SplitTaker {
  public:
    // Both outlive it.
    SplitTaker(Replica& replica, SplitModels& models) : replica_(replica), models_(models) {}

    // Reads the split of a node that can be split, and applies it.  Throws core::Error where it is none.
    void take(RangeDecoder& decoder, uint32_t node, uint16_t& check) {
        replica_.find_ring(replica_.node(node).vertex, ring_);
        replica_.find_place(node, ring_, place_);
        const SplitData data =
            code_split(decoder, models_, replica_.header(), replica_.has_bounds(), place_, SplitData());
        replica_.apply(node, data, ring_);
        check = mixed(check, data.vertex);
    }

    // And the cut vertices of one that waits for another.
    void take_cuts(RangeDecoder& decoder, uint32_t node) {
        replica_.find_ring(replica_.node(node).vertex, ring_);
        replica_.learn_cuts(node, code_cuts(decoder, ring_.neighbours.size(), Cuts()), ring_);
    }

  private:
    Replica& replica_;
    SplitModels& models_;
    Ring ring_;
    SplitPlace place_;
};

}  // namespace pm
