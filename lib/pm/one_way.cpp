#include "pm/one_way.h"

#include <algorithm>

#include "core/error.h"
#include "pm/selection.h"
#include "pm/split_taker.h"

namespace pm {

namespace {

// A pass costs some bits for all that it leaves as it is.
constexpr size_t kLeastOfPass = 256;

}  // namespace

// ---- the server ----

OneWayAnswer::OneWayAnswer(const ServedModel& served, SentRecord& record, const View& view, Culling culling)
    : served_(served), record_(record), tree_(served, record), cursor_(tree_) {
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
    const size_t vertices = size_t(served_.model().header().base_vertices) + record_.count();
    const size_t count = std::min(std::max(kLeastOfPass, vertices), errors.size());
    std::nth_element(errors.begin(), errors.begin() + (std::ptrdiff_t(count) - 1), errors.end(),
                     std::greater<>());
    least_error_ = errors[count - 1];
}

// What it needs may come behind it in the pass; then its turn is in the next one.
bool OneWayAnswer::is_in_pass(uint32_t node) const {
    const auto found = pending_.find(node);
    if (found == pending_.end() || found->second < least_error_) return false;
    const uint32_t needs = served_.model().hierarchy().needs[node];
    return needs == kNone || record_.is_sent(needs);
}

Packet OneWayAnswer::next(uint32_t most_splits) {
    Packet packet;
    RangeEncoder encoder;
    while (packet.decisions != most_splits && !pending_.empty()) {
        const uint32_t node = cursor_.current();
        if (cursor_.begins_pass()) choose_pass();
        if (!cursor_.code(encoder, record_.models, is_in_pass(node))) {
            cursor_.was_left();
            continue;
        }
        tree_.send_split(encoder, node, packet.check);
        pending_.erase(node);
        cursor_.was_split();
        ++packet.decisions;
        ++counts_.splits;
    }
    packet.is_last = pending_.empty();
    packet.bytes = encoder.finish();
    return packet;
}

// ---- the client ----

void take_one_way(Replica& replica, SplitModels& models, PassCursor<Replica>& cursor, uint32_t splits,
                  uint16_t check, std::span<const std::byte> bytes) {
    RangeDecoder decoder(bytes);
    SplitTaker taker(replica, models);
    uint16_t found = 0;
    while (splits > 0) {
        if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
        const uint32_t node = cursor.current();
        if (!cursor.code(decoder, models, false)) {
            cursor.was_left();
            continue;
        }
        taker.take(decoder, node, found);
        cursor.was_split();
        --splits;
    }
    if (decoder.is_beyond_end()) throw core::Error("packet: it is cut off");
    if (found != check) throw core::Error("packet: its check does not match");
}

}  // namespace pm
