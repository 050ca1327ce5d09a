// What a view lacks, as both sides see it: the nodes of a replica (replica.h) that the view wants split, as
// far as the client can know, the largest error on the screen first.
//
// Server and client go through the same nodes in the same turn, so that a packet need not say which node it
// splits.  What the client cannot know are cones that it was not sent, and what a node needs; so a node that
// is looked at here may turn out not to be wanted, which the server then says (split_code.h, Decision).
#pragma once

#include <cstdint>
#include <vector>

#include "pm/replica.h"
#include "pm/view.h"

namespace pm {

class Sweep {
  public:
    // Costs a test for each split whose parent is wanted, and one for each node that is not split.  `replica`
    // outlives it.
    Sweep(const Replica& replica, const View& view, Culling culling = Culling::on);

    // The node that is looked at now; kNone at the end.
    uint32_t current();

    // What was found of current(), after the replica was told.  The next one is then current.
    void was_split();
    void comes_later();   // after all others
    void learned_more();  // its cone, or another's, or its cuts: later, where it is still wanted
    void is_skipped();

    // By split of the replica: is it wanted by this view, as far as is known?  Closed over parents and needs.
    // Those that were received meanwhile are.
    const std::vector<uint8_t>& wanted() const { return wanted_; }
    // A node was found to be stopped by its cone: its split, where it has one, is not wanted any more.
    void cone_learned(uint32_t node);

    // Refine, or what else stops a node.
    Verdict verdict(const NodeBounds& node) const { return test_(node); }

  private:
    struct Entry {
        double error;  // on the screen, or of the path to it what is smallest
        uint32_t node;
    };
    bool comes_before(const Entry& a, const Entry& b) const;
    void push(uint32_t node, double error_of_path);
    void pop();
    bool is_still_wanted(uint32_t node) const;
    double screen_error(const Node& node) const { return test_.screen_error(replica_.bounds(node)); }

    const Replica& replica_;
    RefinementTest test_;
    std::vector<uint8_t> wanted_;
    std::vector<double> path_error_;  // by split
    std::vector<Entry> heap_;
    std::vector<uint32_t> later_;
    bool has_cut_off_ = false;  // nodes that were wanted may not be any more
};

}  // namespace pm
