#include "pm/lists.h"

#include <algorithm>

#include "core/error.h"
#include "pm/split_taker.h"
#include "pm/tree_walk.h"

namespace pm {

namespace {

// A bit for each node that can be split, by its error code: what was wanted of that class before tells.
template <class Coder, class Tree, class IsListed>
void code_list(Coder& coder, SplitModels& models, const Tree& tree, const IsListed& is_listed) {
    for (TreeWalk walk(tree); !walk.is_at_end(); walk.leave()) {
        if (tree.is_leaf(walk.current())) continue;
        BitModel& model = models.listed[tree.error_code(walk.current()) * kErrorClasses / 256];
        is_listed(walk.current(), [&](bool value) { return coder.bit(model, value); });
    }
}

}  // namespace

// ---- what is asked for ----

NodeList make_list(const Replica& replica, SplitModels& models, Sweep<Replica>& sweep, size_t most) {
    NodeList list;
    std::vector<uint8_t> is_listed(replica.nodes().size());
    for (size_t count = 0; count != most && sweep.current() != kNone; ++count) {
        is_listed[sweep.current()] = 1;
        sweep.is_skipped();
    }
    RangeEncoder encoder;
    code_list(encoder, models, replica, [&](uint32_t node, const auto& code) {
        if (code(is_listed[node] != 0)) list.nodes.push_back(node);
    });
    list.bytes = encoder.finish();
    return list;
}

std::vector<uint32_t> read_list(const ServedModel& served, SentRecord& record,
                                std::span<const std::byte> bytes) {
    std::vector<uint32_t> details;
    RangeDecoder decoder(bytes);
    const SentTree tree(served, record);
    code_list(decoder, record.models, tree, [&](uint32_t node, const auto& code) {
        if (code(false)) details.push_back(node);
    });
    if (decoder.is_beyond_end()) throw core::Error("list: it is cut off");
    if (details.empty()) throw core::Error("list: it asks for nothing");
    return details;
}

// ---- the server ----

ListAnswer::ListAnswer(const ServedModel& served, SentRecord& record, std::span<const uint32_t> details)
    : served_(served), record_(record), tree_(served, record), nodes_(details.begin(), details.end()) {}

void ListAnswer::answer(RangeEncoder& encoder, uint32_t n, uint16_t& check) {
    const uint32_t needs = served_.model().hierarchy().needs[n];
    if (needs != kNone && !record_.is_sent(needs)) {
        if (!tree_.send_cuts(encoder, n))
            throw core::Error("list: a split was asked for before what it needs");
        ++counts_.cuts;
        return;
    }
    code_decision(encoder, record_.models, Decision::split);
    tree_.send_split(encoder, n, check);
    ++counts_.splits;
}

Packet ListAnswer::next(uint32_t most_decisions) {
    Packet packet;
    RangeEncoder encoder;
    for (; packet.decisions != most_decisions && answered_ != nodes_.size(); ++packet.decisions)
        answer(encoder, nodes_[answered_++], packet.check);
    packet.is_last = answered_ == nodes_.size();
    packet.bytes = encoder.finish();
    return packet;
}

// ---- the client ----

void take_list_packet(Replica& replica, SplitModels& models, std::span<const uint32_t> nodes, uint16_t check,
                      std::span<const std::byte> bytes) {
    RangeDecoder decoder(bytes);
    SplitTaker splits(replica, models);
    uint16_t found = 0;
    for (const uint32_t n : nodes) {
        const Decision decision = code_decision(decoder, models, Decision::split);
        if (decision == Decision::split) {
            splits.take(decoder, n, found);
        } else if (decision == Decision::cuts) {
            splits.take_cuts(decoder, n);
        } else {
            throw core::Error("packet: it answers a list with what was not asked for");
        }
    }
    if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
    if (found != check) throw core::Error("packet: its check does not match");
}

}  // namespace pm
