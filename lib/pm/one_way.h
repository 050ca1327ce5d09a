// Splits for clients that will not coarsen: without the bounds by which they could refine by themselves.
//
// Kim, Lee, Kobbelt, section 6.3, where the server puts cut vertices in the place of fundamental ones and
// leaves refinement data out.  Here cut vertices are those of the client's mesh in any case (replica.h), and
// what is left out are bounds; so a client cannot go through nodes as the server does (sweep.h), and a packet
// has to say which ones it splits: a bit for each vertex of the mesh, in passes over all of them.  A server
// chooses freely what it splits in a pass.  This one takes those of the largest error on the screen, about as
// many as the mesh has vertices, so that passes are few and what comes first is what is seen most.
#pragma once

#include <span>
#include <unordered_map>

#include "pm/packet_source.h"
#include "pm/served_model.h"
#include "pm/tree_walk.h"
#include "pm/view.h"

namespace pm {

// Where both sides are.
class PassCursor {
  public:
    explicit PassCursor(const Replica& replica) : replica_(&replica), walk_(replica) {}

    bool begins_pass() const { return is_begin_; }
    // Begins the next pass at the end of one.  Throws core::Error where that has split nothing.
    uint32_t current();
    template <class Coder>
    bool code(Coder& coder, SplitModels& models, bool is_split) const {
        return coder.bit(models.pass[age_ * 2 + size_t(last_)], is_split);
    }
    void was_split();
    void was_left();

  private:
    const Replica* replica_;
    TreeWalk walk_;
    // Of current(): is it a child of what this pass has split, 0 (no) to 2; was the one before it split?
    size_t age_ = 0;
    bool last_ = false, is_begin_ = true, has_split_ = false;
    uint32_t nodes_before_ = 0;  // which the replica had when the pass began
};

class OneWayAnswer final : public PacketSource {
  public:
    // All of them outlive it.
    OneWayAnswer(const ServedModel& served, SentRecord& record, ServedReplica& replica, const View& view,
                 Culling culling = Culling::on);
    Packet next(uint32_t most_splits) override;

  private:
    void choose_pass();
    bool is_in_pass(uint32_t detail) const;

    const ServedModel& served_;
    SentRecord& record_;
    ServedReplica& replica_;
    // By detail that is wanted and was not sent: its error on the screen, or on the way to it what is least.
    std::unordered_map<uint32_t, double> pending_;
    double least_error_ = 0;  // of this pass
    PassCursor cursor_;
    Ring ring_;
};

// The client's side, as take_packet() in answer.h.
void take_one_way(Replica& replica, SplitModels& models, PassCursor& cursor, uint32_t splits, uint16_t check,
                  std::span<const std::byte> bytes);

}  // namespace pm
