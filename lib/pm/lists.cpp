#include "pm/lists.h"

#include <algorithm>
#include <unordered_map>

#include "core/error.h"
#include "pm/tree_walk.h"

namespace pm {

namespace {

// A bit for each node that can be split, by its error code: what was wanted of that class before tells.
template <class Coder, class IsListed>
void code_list(Coder& coder, SplitModels& models, const Replica& replica, const IsListed& is_listed) {
    for (TreeWalk walk(replica); walk.current() != kNone; walk.leave()) {
        const Node& node = replica.node(walk.current());
        if (node.is_leaf) continue;
        BitModel& model = models.listed[node.error * kErrorClasses / 256];
        is_listed(walk.current(), [&](bool value) { return coder.bit(model, value); });
    }
}

}  // namespace

// ---- what is asked for ----

NodeList make_list(const Replica& replica, SplitModels& models, Sweep& sweep, size_t most) {
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

std::vector<uint32_t> read_list(const ServedReplica& replica, SplitModels& models,
                                std::span<const std::byte> bytes) {
    std::vector<uint32_t> details;
    RangeDecoder decoder(bytes);
    code_list(decoder, models, replica.replica(), [&](uint32_t node, const auto& code) {
        if (code(false)) details.push_back(replica.detail_of(node));
    });
    if (decoder.is_beyond_end()) throw core::Error("list: it is cut off");
    if (details.empty()) throw core::Error("list: it asks for nothing");
    return details;
}

// ---- the server ----

ListAnswer::ListAnswer(const ServedModel& served, SentRecord& record, ServedReplica& replica,
                       std::span<const uint32_t> details)
    : served_(served), record_(record), replica_(replica) {
    std::unordered_map<uint32_t, size_t> place;
    for (size_t i = 0; i != details.size(); ++i) place[details[i]] = i;
    nodes_.resize(details.size());
    for (uint32_t n = 0; n != replica.replica().nodes().size(); ++n)
        if (const auto found = place.find(replica.detail_of(n)); found != place.end())
            nodes_[found->second] = n;
}

void ListAnswer::answer(RangeEncoder& encoder, uint32_t n, uint16_t& check) {
    Replica& have = replica_.replica();
    const uint32_t detail = replica_.detail_of(n), needs = served_.model().hierarchy().needs[detail];
    have.find_ring(have.node(n).vertex, ring_);
    if (needs != kNone && !record_.is_sent(needs)) {
        const Cuts cuts = replica_.cuts(record_, n, ring_);
        const uint32_t known = have.node(n).needs;
        have.learn_cuts(n, cuts.left, cuts.right, ring_);
        if (have.node(n).needs == known)
            throw core::Error("list: a split was asked for before what it needs");
        code_decision(encoder, record_.models, Decision::cuts);
        code_cuts(encoder, record_.models, ring_, cuts);
        record_.block(detail, replica_.detail_of(have.node(n).needs));
        ++counts_.cuts;
        return;
    }
    const SplitData data = replica_.split_data(record_, n, ring_);
    code_decision(encoder, record_.models, Decision::split);
    code_split(encoder, record_.models, have, n, ring_, data);
    check = mixed(check, data.vertex);
    replica_.apply(n, data, ring_);
    record_.add(detail);
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
    Ring ring;
    uint16_t found = 0;
    for (const uint32_t n : nodes) {
        const Decision decision = code_decision(decoder, models, Decision::split);
        replica.find_ring(replica.node(n).vertex, ring);
        if (decision == Decision::split) {
            const SplitData data = code_split(decoder, models, replica, n, ring, SplitData());
            replica.apply(n, data, ring);
            found = mixed(found, data.vertex);
        } else if (decision == Decision::cuts) {
            const Cuts cuts = code_cuts(decoder, models, ring, Cuts());
            replica.learn_cuts(n, cuts.left, cuts.right, ring);
        } else {
            throw core::Error("packet: it answers a list with what was not asked for");
        }
    }
    if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
    if (found != check) throw core::Error("packet: its check does not match");
}

}  // namespace pm
