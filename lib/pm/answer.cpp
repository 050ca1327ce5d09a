#include "pm/answer.h"

#include <algorithm>

#include "core/error.h"
#include "pm/split_taker.h"

namespace pm {

Answer::Answer(const ServedModel& served, SentRecord& record, const View& view, Culling culling)
    : served_(served),
      hierarchy_(served.model().hierarchy()),
      record_(record),
      tree_(served, record),
      sweep_(tree_, view, served.model().header().placement, culling),
      wanted_(record.end()) {
    record.for_each([&](uint32_t n) {
        // What the client does not want as far as it knows is not.
        if (!sweep_.is_wanted(n)) return;
        const uint32_t needs = hierarchy_.needs[n];
        wanted_[n] =
            is_parent_wanted(n) && (needs == kNone || wanted_[needs]) && verdict(n) == Verdict::refine;
    });
}

bool Answer::is_parent_wanted(uint32_t n) const {
    return hierarchy_.parent[n] == kNone || wanted_[hierarchy_.parent[n]];
}

// With all that the model knows; the stack holds what is to be known first.
bool Answer::is_wanted(uint32_t node) {
    if (const auto known = is_wanted_.find(node); known != is_wanted_.end()) return known->second;
    std::vector<uint32_t> stack = {node};
    while (!stack.empty()) {
        const uint32_t n = stack.back();
        bool is_known = true, is_so = verdict(n) == Verdict::refine;
        for (const uint32_t on : {hierarchy_.parent[n], hierarchy_.needs[n]}) {
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
            while (stack.back() != n) stack.pop_back();
            stack.pop_back();
            is_wanted_[n] = is_so;
        }
    }
    return is_wanted_.at(node);
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
    const uint32_t needs = hierarchy_.needs[n];
    const bool stands = verdict(n) == Verdict::refine && is_parent_wanted(n);
    if (stands && (needs == kNone || is_wanted(needs))) {
        if (needs == kNone || record_.is_sent(needs)) {
            code_decision(encoder, record_.models, Decision::split);
            tree_.send_split(encoder, n, check);
            wanted_.resize(record_.end());
            wanted_[n] = true;
            ++counts_.splits;
            return sweep_.was_split();
        }
        const uint32_t sent = record_.count();
        const auto delayed = delayed_at_.find(n);
        if (delayed == delayed_at_.end() || delayed->second != sent) {
            delayed_at_[n] = sent;
            code_decision(encoder, record_.models, Decision::later);
            ++counts_.delays;
            return sweep_.comes_later();
        }
    } else if (stands && tree_.send_cuts(encoder, n)) {
        ++counts_.cuts;
        return sweep_.learned_more();
    } else if (send_cone(encoder, n)) {
        return sweep_.learned_more();
    }
    code_decision(encoder, record_.models, Decision::skip);
    ++counts_.skips;
    sweep_.is_skipped();
}

// From a node up its parents, or over to what one of them needs, to one that only its cone stops.
bool Answer::find_cone(uint32_t n, std::vector<bool>& way, uint32_t& found) const {
    for (;;) {
        if (!tree_.knows_cone(n) && verdict(n) == Verdict::faces_away) {
            found = n;
            return true;
        }
        const bool is_parent_at_fault = !is_parent_wanted(n);
        const uint32_t up = is_parent_at_fault ? tree_.parent(n) : tree_.needs(n);
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
    code_cone(encoder, served_.model().cone(found));
    tree_.learn_cone(found);
    sweep_.cone_learned(found);
    ++counts_.cones;
    return true;
}

// ---- the client's side ----

namespace {

void take_cone(Replica& replica, SplitModels& models, Sweep<Replica>& sweep, RangeDecoder& decoder,
               uint32_t n) {
    while (decoder.bit(models.climbs)) {
        const Node& node = replica.node(n);
        n = decoder.bit(models.climbs_to_needs) ? node.needs : node.parent;
        if (n == kNone) throw core::Error("packet: it names a node that is not there");
    }
    replica.learn_cone(n, code_cone(decoder, ConeCodes{}));
    sweep.cone_learned(n);
}

}  // namespace

void take_packet(Replica& replica, SplitModels& models, Sweep<Replica>& sweep, uint32_t decisions,
                 uint16_t check, std::span<const std::byte> bytes) {
    RangeDecoder decoder(bytes);
    SplitTaker splits(replica, models);
    uint16_t found = 0;
    for (; decisions > 0; --decisions) {
        const uint32_t node = sweep.current();
        if (node == kNone) throw core::Error("packet: it says more than the view asks");
        switch (code_decision(decoder, models, Decision::split)) {
            case Decision::split:
                splits.take(decoder, node, found);
                sweep.was_split();
                break;
            case Decision::later:
                sweep.comes_later();
                break;
            case Decision::cone:
                take_cone(replica, models, sweep, decoder, node);
                sweep.learned_more();
                break;
            case Decision::cuts:
                splits.take_cuts(decoder, node);
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
