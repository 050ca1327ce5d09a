// What a view lacks, as both sides see it: the nodes that the client has and that the view wants split, as
// far as the client can know, the largest error on the screen first.
//
// Server and client go through the same nodes in the same turn, so that a packet need not say which node it
// splits.  What the client cannot know are cones that it was not sent, and what a node needs; so a node that
// is looked at here may turn out not to be wanted, which the server then says (split_code.h, Decision).
//
// Nothing is remembered from one view to the next: the tree is gone through from its roots each time.
#pragma once

#include <cstdint>
#include <vector>

#include "pm/view.h"

namespace pm {

// `Tree` is the client's Replica (replica.h), or what the server finds of it in the model (SentTree).
template <class Tree>
class Sweep {
  public:
    // Costs a test for each split whose parent is wanted, and one for each child of these that is not split.
    // `tree` outlives it.
    Sweep(const Tree& tree, const View& view, const Placement& placement, Culling culling = Culling::on);

    // The node that is looked at now; kNone at the end.
    uint32_t current();

    // What was found of current(), after the tree was told.  The next one is then current.
    void was_split();
    void comes_later();   // after all others
    void learned_more();  // its cone, or another's, or its cuts: later, where it is still wanted
    void is_skipped();

    // Is a node split, and wanted by this view, as far as is known?  Closed over parents and needs.  What was
    // split meanwhile is.
    bool is_wanted(uint32_t node) const { return node < wanted_.size() && wanted_[node]; }
    // A node was found to be stopped by its cone: its split, where it has one, is not wanted any more.
    void cone_learned(uint32_t node);

    // Refine, or what else stops a node.
    Verdict verdict(const NodeBounds& node) const { return test_(node); }

  private:
    struct Entry {
        double error;  // on the screen, or of the path to it what is smallest
        uint32_t node;
    };
    void find_wanted();
    void find_candidates();
    bool are_needs_wanted(uint32_t node) const {
        const uint32_t needs = tree_.needs(node);
        return needs == kNone || is_wanted(needs);
    }
    bool comes_before(const Entry& a, const Entry& b) const;
    void push(uint32_t node, double error_of_path);
    void pop();
    bool is_still_wanted(uint32_t node) const;

    const Tree& tree_;
    RefinementTest test_;
    std::vector<bool> wanted_;  // by node
    std::vector<Entry> heap_;
    std::vector<uint32_t> later_;
    bool has_cut_off_ = false;  // nodes that were wanted may not be any more
};

}  // namespace pm
