// What a client has of a model, as the server finds it: in the model itself, by the splits that were sent.
//
// The wanted set of a view is closed under parents and needs, so what was sent is, and of each face of the
// model it is known whether the client has it: where the detail that adds it was sent.  So nothing but the
// record is kept of a client, and all clients share the rest.
//
// A node is named by the detail that splits it; leaves of the model are kLeaf.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "pm/served_model.h"

namespace pm {

class SentTree {
  public:
    static constexpr uint32_t kLeaf = kNone - 1;

    // Both outlive it.
    SentTree(const ServedModel& served, SentRecord& record);

    const ServedModel& served() const { return served_; }
    SentRecord& record() { return record_; }
    const SentRecord& record() const { return record_; }

    // ---- the tree, for sweep.h and tree_walk.h ----

    uint32_t end_of_splits() const { return record_.end(); }
    template <class Use>
    void for_each_split(const Use& use) const {
        record_.for_each(use);
    }
    template <class Use>
    void for_each_root(const Use& use) const {
        for (const uint32_t v : served_.base_order()) use(named(served_.model().root_split()[v]));
    }
    bool is_split(uint32_t n) const { return n != kLeaf && record_.is_sent(n); }
    bool is_leaf(uint32_t n) const { return n == kLeaf; }
    uint32_t parent(uint32_t n) const { return tree_.parent[n]; }
    // What the client knows of it.
    uint32_t needs(uint32_t n) const { return record_.is_sent(n) ? tree_.needs[n] : record_.waits_for(n); }
    std::array<uint32_t, 2> children(uint32_t n) const {
        return {named(children_[n].kept), named(children_[n].fresh)};
    }
    uint8_t error_code(uint32_t n) const { return served_.model().error_code(n); }
    NodeBounds bounds(uint32_t n) const {  // with its cone, if that was sent
        NodeBounds bounds = served_.bounds(n);
        if (!knows_cone(n)) bounds.cone = {};
        return bounds;
    }
    // Of nodes of which none is above the other.
    bool precedes(uint32_t a, uint32_t b) const {
        return served_.faces().rank(tree_.kept[a]) < served_.faces().rank(tree_.kept[b]);
    }

    // ---- what is sent ----

    bool knows_cone(uint32_t n) const { return n < knows_cone_.size() && knows_cone_[n]; }
    void learn_cone(uint32_t n);

    // Writes the split of a node that can be split, and adds it to the record and to the check of the packet.
    // Throws core::Error where the model's faces make no ring, or the cut vertices are not in it.
    void send_split(RangeEncoder& encoder, uint32_t n, uint16_t& check);
    // Writes that the cut vertices of a node follow, and them, by which the client knows what it waits for.
    // False where it knows that.
    bool send_cuts(RangeEncoder& encoder, uint32_t n);

  private:
    struct Spoke {
        uint32_t next, previous;  // the other corners of a face, in turn
    };
    void mark_cone(uint32_t n);
    static uint32_t named(uint32_t detail) { return detail == kNone ? kLeaf : detail; }
    uint32_t node_waited_for(uint32_t n) const;
    uint32_t active(uint32_t leaf) const;
    void find_place(uint32_t n);
    void find_spokes(uint32_t n);
    void find_ring();
    bool is_lower(uint32_t vertex, uint32_t than) const;
    int position_of(uint32_t leaf) const;
    Cuts cuts(uint32_t n) const;
    [[noreturn]] void fail() const;

    const ServedModel& served_;
    SentRecord& record_;
    Hierarchy tree_;
    std::span<const Children> children_;
    std::vector<bool> knows_cone_;  // by node, up to the last one
    // Of the node that was looked at last.
    std::vector<Spoke> spokes_;
    std::vector<bool> is_behind_;
    std::vector<uint32_t> ring_;
    SplitPlace place_;
};

}  // namespace pm
