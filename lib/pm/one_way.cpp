#include "pm/one_way.h"

#include <algorithm>

#include "core/error.h"
#include "pm/selection.h"

namespace pm {

namespace {

// A pass costs some bits for all that it leaves as it is.
constexpr size_t kLeastOfPass = 256;

}  // namespace

// ---- passes ----

uint32_t PassCursor::current() {
    if (walk_.current() == kNone) {
        if (!has_split_) throw core::Error("packet: a pass splits nothing");
        *this = PassCursor(*replica_);
    }
    if (is_begin_) nodes_before_ = uint32_t(replica_->nodes().size());
    const uint32_t node = walk_.current();
    const uint32_t parent = replica_->node(node).parent;
    age_ = node < nodes_before_ ? 0 : node == replica_->node(parent).kept_child ? 1 : 2;
    return node;
}

void PassCursor::was_split() {
    walk_.was_split();
    last_ = has_split_ = true;
    is_begin_ = false;
}

void PassCursor::was_left() {
    walk_.leave();
    last_ = is_begin_ = false;
}

// ---- the server ----

OneWayAnswer::OneWayAnswer(const ServedModel& served, SentRecord& record, ServedReplica& replica,
                           const View& view, Culling culling)
    : served_(served), record_(record), replica_(replica), cursor_(replica.replica()) {
    const Model& model = served.model();
    const Hierarchy tree = model.hierarchy();
    const RefinementTest test(view, model.header().placement, culling);
    Selection selection(model);
    const std::vector<uint32_t>& wanted = selection.select(view, culling);
    std::vector<double> errors(wanted.size());
    for (size_t i = 0; i != wanted.size(); ++i) {
        errors[i] = test.screen_error(model.bounds(wanted[i]));
        // What a detail depends on is wanted too, and stands before it.
        for (const uint32_t on : {tree.parent[wanted[i]], tree.needs[wanted[i]]})
            if (on != kNone)
                errors[i] = std::min(
                    errors[i],
                    errors[size_t(std::lower_bound(wanted.begin(), wanted.end(), on) - wanted.begin())]);
        if (!record.is_sent(wanted[i])) pending_[wanted[i]] = errors[i];
    }
}

void OneWayAnswer::choose_pass() {
    std::vector<double> errors;
    for (const auto& [detail, error] : pending_) errors.push_back(error);
    const size_t count =
        std::min(std::max(kLeastOfPass, size_t(replica_.replica().vertex_count())), errors.size());
    std::nth_element(errors.begin(), errors.begin() + (std::ptrdiff_t(count) - 1), errors.end(),
                     std::greater<>());
    least_error_ = errors[count - 1];
}

// What it needs may come behind it in the pass; then its turn is in the next one.
bool OneWayAnswer::is_in_pass(uint32_t detail) const {
    const auto found = pending_.find(detail);
    if (found == pending_.end() || found->second < least_error_) return false;
    const uint32_t needs = served_.model().hierarchy().needs[detail];
    return needs == kNone || record_.is_sent(needs);
}

Packet OneWayAnswer::next(uint32_t most_splits) {
    Packet packet;
    RangeEncoder encoder;
    Replica& have = replica_.replica();
    while (packet.decisions != most_splits && !pending_.empty()) {
        const uint32_t node = cursor_.current();
        if (cursor_.begins_pass()) choose_pass();
        const uint32_t detail = replica_.detail_of(node);
        if (!cursor_.code(encoder, record_.models, detail != kNone && is_in_pass(detail))) {
            cursor_.was_left();
            continue;
        }
        have.find_ring(have.node(node).vertex, ring_);
        const SplitData data = replica_.split_data(record_, node, ring_);
        code_split(encoder, record_.models, have, node, ring_, data);
        packet.check = mixed(packet.check, data.vertex);
        replica_.apply(node, data, ring_);
        record_.add(detail);
        pending_.erase(detail);
        cursor_.was_split();
        ++packet.decisions;
        ++counts_.splits;
    }
    packet.is_last = pending_.empty();
    packet.bytes = encoder.finish();
    return packet;
}

// ---- the client ----

void take_one_way(Replica& replica, SplitModels& models, PassCursor& cursor, uint32_t splits, uint16_t check,
                  std::span<const std::byte> bytes) {
    RangeDecoder decoder(bytes);
    Ring ring;
    uint16_t found = 0;
    while (splits > 0) {
        if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
        const uint32_t node = cursor.current();
        if (!cursor.code(decoder, models, false)) {
            cursor.was_left();
            continue;
        }
        replica.find_ring(replica.node(node).vertex, ring);
        const SplitData data = code_split(decoder, models, replica, node, ring, SplitData());
        replica.apply(node, data, ring);
        found = mixed(found, data.vertex);
        cursor.was_split();
        --splits;
    }
    if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
    if (found != check) throw core::Error("packet: its check does not match");
}

}  // namespace pm
