#include "splat/walk.h"

#include <deque>

#include "core/error.h"

namespace splat {

namespace {

class Walk {
  public:
    Walk(const Model& model, uint32_t last_level, const std::function<void(const WalkedNode&)>& use)
        : model_(model),
          last_level_(last_level),
          use_(use),
          read_(model.layout().capacity),
          queued_(model.layout().capacity) {}

    void run() {
        if (last_level_ == 0) return;
        const Node root = model_.root();
        queued_.place(uint32_t(root.children));
        queue_.push_back(root);
        for (uint32_t level = 1; !queue_.empty(); ++level) {
            if (level > model_.header().level_count)
                model_.fault(block_.number(),
                             core::text("has nodes with children on level %u, the last one", level - 1));
            for (size_t groups = queue_.size(); groups > 0; --groups) {
                const Node parent = queue_.front();
                queue_.pop_front();
                read_group(parent, level);
            }
        }
        if (last_level_ < model_.header().level_count) return;
        leave_block(read_.slot());
        if (block_.number() + 1 != model_.node_blocks_present())
            model_.fault(block_.number() + 1, "no node has children here");
    }

  private:
    void read_group(const Node& parent, uint32_t level) {
        const uint32_t used = read_.slot();
        const GroupAt at = read_.place(uint32_t(parent.children));
        if (!block_.is_open() || at.block != block_.number()) {
            if (block_.is_open()) leave_block(used);
            block_.open(model_, at.block);
        }
        if (read_.slot() > block_.node_count())
            model_.fault(at.block, core::text("%u nodes, a group ends with slot %u", block_.node_count(),
                                              read_.slot() - 1));
        const Frame frame = frame_about(parent.normal);
        for (uint32_t slot = at.slot; slot < read_.slot(); ++slot) {
            const Node node =
                decode_node(block_.attitude()[slot], block_.place()[slot], block_.shape_of(slot),
                            block_.colour() ? block_.colour()[slot] : uint16_t(0), parent, frame);
            bool lacks_children = false;
            if (node.children > 0) {
                lacks_children = !model_.has_block(child_group(slot, node.children).block);
                if (!lacks_children && level < last_level_) queue_.push_back(node);
            }
            use_({{at.block, slot}, level, node, parent, lacks_children});
        }
    }

    // Where the children of the node in `slot` are.
    GroupAt child_group(uint32_t slot, int children) {
        const GroupAt found = block_.group_of(slot), expected = queued_.place(uint32_t(children));
        if (found != expected)
            model_.fault(
                block_.number(),
                core::text(
                    "children of slot %u at block %llu slot %u, the order puts them at block %llu slot %u",
                    slot, static_cast<unsigned long long>(found.block), found.slot,
                    static_cast<unsigned long long>(expected.block), expected.slot));
        if (expected.block >= model_.header().node_blocks())
            model_.fault(block_.number(), core::text("children of slot %u are beyond the last block", slot));
        return expected;
    }

    void leave_block(uint32_t used) const {
        if (used != block_.node_count())
            model_.fault(block_.number(),
                         core::text("%u nodes, its groups have %u", block_.node_count(), used));
    }

    const Model& model_;
    const uint32_t last_level_;
    const std::function<void(const WalkedNode&)>& use_;
    BlockView block_;
    GroupCursor read_,
        queued_;  // the group that is read, and the last that was found to be someone's children
    std::deque<Node> queue_;
};

}  // namespace

void walk(const Model& model, uint32_t last_level, const std::function<void(const WalkedNode&)>& use) {
    Walk(model, last_level, use).run();
}

void walk_cut(const Model& model, uint32_t level, const std::function<void(const Node&)>& use) {
    const Node root = model.root();
    if (level == 0 || root.children == 0) return use(root);
    walk(model, level, [&](const WalkedNode& n) {
        if (n.level == level || n.node.children == 0 || n.lacks_children) use(n.node);
    });
}

}  // namespace splat
