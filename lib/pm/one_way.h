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

#include "core/error.h"
#include "pm/packet_source.h"
#include "pm/replica.h"
#include "pm/sent_tree.h"
#include "pm/tree_walk.h"
#include "pm/view.h"

namespace pm {

// Where both sides are.  `Tree` as in sweep.h.
template <class Tree>
class PassCursor {
  public:
    explicit PassCursor(const Tree& tree) : tree_(&tree), walk_(tree) {}

    bool begins_pass() const { return is_begin_; }
    // Begins the next pass at the end of one.  Throws core::Error where that has split nothing.
    uint32_t current() {
        if (walk_.is_at_end()) {
            if (!has_split_) throw core::Error("packet: a pass splits nothing");
            *this = PassCursor(*tree_);
        }
        return walk_.current();
    }
    template <class Coder>
    bool code(Coder& coder, SplitModels& models, bool is_split) const {
        return coder.bit(models.pass[walk_.age() * 2 + size_t(last_)], is_split);
    }
    void was_split() {
        walk_.was_split();
        last_ = has_split_ = true;
        is_begin_ = false;
    }
    void was_left() {
        walk_.leave();
        last_ = is_begin_ = false;
    }

  private:
    const Tree* tree_;
    TreeWalk<Tree> walk_;
    bool last_ = false;  // the node before current() was split
    bool is_begin_ = true, has_split_ = false;
};

class OneWayAnswer final : public PacketSource {
  public:
    // Both outlive it.
    OneWayAnswer(const ServedModel& served, SentRecord& record, const View& view,
                 Culling culling = Culling::on);
    Packet next(uint32_t most_splits) override;

  private:
    void choose_pass();
    bool is_in_pass(uint32_t node) const;

    const ServedModel& served_;
    SentRecord& record_;
    SentTree tree_;
    // By node that is wanted split and was not: its error on the screen, or on the way to it what is least.
    std::unordered_map<uint32_t, double> pending_;
    double least_error_ = 0;  // of this pass
    PassCursor<SentTree> cursor_;
};

// The client's side, as take_packet() in answer.h.
void take_one_way(Replica& replica, SplitModels& models, PassCursor<Replica>& cursor, uint32_t splits,
                  uint16_t check, std::span<const std::byte> bytes);

}  // namespace pm
