#include "pm/answer.h"

#include <algorithm>

#include "core/error.h"

namespace pm {

Answer::Answer(const ServedModel& served, SentRecord& record, ServedReplica& replica, const View& view,
               Culling culling)
    : served_(served), record_(record), replica_(replica), sweep_(replica.replica(), view, culling) {
    const Replica& have = replica.replica();
    wanted_.assign(have.split_count(), 0);
    for (uint32_t s = 0; s != have.split_count(); ++s) {
        if (sweep_.wanted()[s] == 0) continue;  // what the client does not want as far as it knows is not
        const Node& node = have.node(have.node_of_split(s));
        const auto is_split_wanted = [&](uint32_t n) {
            return n == kNone || wanted_[have.node(n).split] != 0;
        };
        wanted_[s] = is_split_wanted(node.parent) && is_split_wanted(node.needs) &&
                     verdict(replica.detail_of(have.node_of_split(s))) == Verdict::refine;
    }
}

bool Answer::is_parent_wanted(const Node& node) const {
    return node.parent == kNone || wanted_[replica_.replica().node(node.parent).split] != 0;
}

// With all that the model knows; the stack holds what is to be known first.
bool Answer::is_wanted(uint32_t detail) {
    if (const auto known = is_wanted_.find(detail); known != is_wanted_.end()) return known->second;
    const Hierarchy tree = served_.model().hierarchy();
    std::vector<uint32_t> stack = {detail};
    while (!stack.empty()) {
        const uint32_t d = stack.back();
        bool is_known = true, is_so = verdict(d) == Verdict::refine;
        for (const uint32_t on : {tree.parent[d], tree.needs[d]}) {
            if (on == kNone || !is_so) continue;
            const auto known = is_wanted_.find(on);
            if (known == is_wanted_.end()) {
                is_known = false;
                stack.push_back(on);
            } else {
                is_so = is_so && known->second;
            }
        }
        if (!is_so || is_known) {
            while (stack.back() != d) stack.pop_back();
            stack.pop_back();
            is_wanted_[d] = is_so;
        }
    }
    return is_wanted_.at(detail);
}

Packet Answer::next(uint32_t most_decisions) {
    Packet packet;
    RangeEncoder encoder;
    while (packet.decisions != most_decisions) {
        const uint32_t node = sweep_.current();
        if (node == kNone) break;
        decide(encoder, node, packet.check);
        ++packet.decisions;
    }
    packet.is_last = sweep_.current() == kNone;
    packet.bytes = encoder.finish();
    return packet;
}

void Answer::decide(RangeEncoder& encoder, uint32_t n, uint16_t& check) {
    const uint32_t needs = served_.model().hierarchy().needs[replica_.detail_of(n)];
    const Node& node = replica_.replica().node(n);
    const bool stands = verdict(replica_.detail_of(n)) == Verdict::refine && is_parent_wanted(node);
    if (stands && (needs == kNone || is_wanted(needs))) {
        if (needs == kNone || record_.is_sent(needs)) return send_split(encoder, n, check);
        const uint32_t sent = record_.count();
        const auto delayed = delayed_at_.find(n);
        if (delayed == delayed_at_.end() || delayed->second != sent) {
            delayed_at_[n] = sent;
            code_decision(encoder, record_.models, Decision::later);
            ++counts_.delays;
            return sweep_.comes_later();
        }
    } else if ((stands && send_cuts(encoder, n)) || send_cone(encoder, n)) {
        return sweep_.learned_more();
    }
    code_decision(encoder, record_.models, Decision::skip);
    ++counts_.skips;
    sweep_.is_skipped();
}

void Answer::send_split(RangeEncoder& encoder, uint32_t n, uint16_t& check) {
    Replica& have = replica_.replica();
    have.find_ring(have.node(n).vertex, ring_);
    const SplitData data = replica_.split_data(record_, n, ring_);
    code_decision(encoder, record_.models, Decision::split);
    code_split(encoder, record_.models, have, n, ring_, data);
    check = mixed(check, data.vertex);
    const uint32_t detail = replica_.detail_of(n);
    replica_.apply(n, data, ring_);
    record_.add(detail);
    wanted_.push_back(1);
    ++counts_.splits;
    sweep_.was_split();
}

// False where the client knows what this says.
bool Answer::send_cuts(RangeEncoder& encoder, uint32_t n) {
    Replica& have = replica_.replica();
    have.find_ring(have.node(n).vertex, ring_);
    const Cuts cuts = replica_.cuts(record_, n, ring_);
    if (cuts.left < 0 || cuts.right < 0) return false;
    const uint32_t before = have.node(n).needs;
    have.learn_cuts(n, cuts.left, cuts.right, ring_);
    if (have.node(n).needs == before) return false;
    code_decision(encoder, record_.models, Decision::cuts);
    code_cuts(encoder, record_.models, ring_, cuts);
    const uint32_t detail = replica_.detail_of(n), needs = have.node(n).needs;
    record_.block(detail, needs == kNone ? kNone : replica_.detail_of(needs));
    ++counts_.cuts;
    return true;
}

// From a node up its parents, or over to what one of them needs, to one that only its cone stops.
bool Answer::find_cone(uint32_t n, std::vector<bool>& way, uint32_t& found) const {
    const Replica& have = replica_.replica();
    for (;;) {
        const Node& node = have.node(n);
        if (!node.has_cone && verdict(replica_.detail_of(n)) == Verdict::faces_away) {
            found = n;
            return true;
        }
        const bool is_parent_at_fault = !is_parent_wanted(node);
        const uint32_t up = is_parent_at_fault ? node.parent : node.needs;
        if (up == kNone) return false;
        way.push_back(!is_parent_at_fault);
        n = up;
    }
}

bool Answer::send_cone(RangeEncoder& encoder, uint32_t n) {
    std::vector<bool> way;
    uint32_t found = kNone;
    if (!find_cone(n, way, found)) return false;
    SplitModels& models = record_.models;
    code_decision(encoder, models, Decision::cone);
    for (const bool to_needs : way) {
        encoder.bit(models.climbs, true);
        encoder.bit(models.climbs_to_needs, to_needs);
    }
    encoder.bit(models.climbs, false);
    const uint32_t detail = replica_.detail_of(found);
    replica_.replica().learn_cone(found, code_cone(encoder, served_.model().cone(detail)));
    record_.cones.push_back(detail);
    sweep_.cone_learned(found);
    ++counts_.cones;
    return true;
}

// ---- the client's side ----

namespace {

void take_split(Replica& replica, SplitModels& models, Sweep& sweep, RangeDecoder& decoder, uint32_t n,
                Ring& ring, uint16_t& check) {
    replica.find_ring(replica.node(n).vertex, ring);
    const SplitData data = code_split(decoder, models, replica, n, ring, SplitData());
    replica.apply(n, data, ring);
    check = mixed(check, data.vertex);
    sweep.was_split();
}

void take_cuts(Replica& replica, SplitModels& models, RangeDecoder& decoder, uint32_t n, Ring& ring) {
    replica.find_ring(replica.node(n).vertex, ring);
    const Cuts cuts = code_cuts(decoder, models, ring, Cuts());
    replica.learn_cuts(n, cuts.left, cuts.right, ring);
}

void take_cone(Replica& replica, SplitModels& models, Sweep& sweep, RangeDecoder& decoder, uint32_t n) {
    while (decoder.bit(models.climbs)) {
        const Node& node = replica.node(n);
        n = decoder.bit(models.climbs_to_needs) ? node.needs : node.parent;
        if (n == kNone) throw core::Error("packet: it names a node that is not there");
    }
    replica.learn_cone(n, code_cone(decoder, ConeCodes{}));
    sweep.cone_learned(n);
}

}  // namespace

void take_packet(Replica& replica, SplitModels& models, Sweep& sweep, uint32_t decisions, uint16_t check,
                 std::span<const std::byte> bytes) {
    RangeDecoder decoder(bytes);
    Ring ring;
    uint16_t found = 0;
    for (; decisions > 0; --decisions) {
        const uint32_t node = sweep.current();
        if (node == kNone) throw core::Error("packet: it says more than the view asks");
        switch (code_decision(decoder, models, Decision::split)) {
            case Decision::split:
                take_split(replica, models, sweep, decoder, node, ring, found);
                break;
            case Decision::later:
                sweep.comes_later();
                break;
            case Decision::cone:
                take_cone(replica, models, sweep, decoder, node);
                sweep.learned_more();
                break;
            case Decision::cuts:
                take_cuts(replica, models, decoder, node, ring);
                sweep.learned_more();
                break;
            case Decision::skip:
                sweep.is_skipped();
                break;
        }
    }
    if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
    if (found != check) throw core::Error("packet: its check does not match");
}

}  // namespace pm
