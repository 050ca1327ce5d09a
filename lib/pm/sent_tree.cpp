#include "pm/sent_tree.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "pm/build/details.h"
#include "pm/packet_source.h"

namespace pm {

SentTree::SentTree(const ServedModel& served, SentRecord& record)
    : served_(served),
      record_(record),
      tree_(served.model().hierarchy()),
      children_(served.model().children()) {
    for (const uint32_t n : record.cones) mark_cone(n);
}

void SentTree::mark_cone(uint32_t n) {
    if (n >= knows_cone_.size()) knows_cone_.resize(n + 1);
    knows_cone_[n] = true;
}

void SentTree::learn_cone(uint32_t n) {
    record_.cones.push_back(n);
    mark_cone(n);
}

// ---- rings ----

// The vertex of the client's mesh that a leaf is below.
uint32_t SentTree::active(uint32_t leaf) const {
    while (leaf >= tree_.base_vertices && !record_.is_sent(leaf - tree_.base_vertices))
        leaf = tree_.kept[leaf - tree_.base_vertices];
    return leaf;
}

void SentTree::fail() const {
    throw core::Error(served_.model().name() +
                      ": a cut vertex is not in its ring; 'qs-info --verify' says more");
}

void SentTree::find_spokes(uint32_t n) {
    const FaceIndex& faces = served_.faces();
    spokes_.clear();
    for (const uint32_t face : faces.around(n)) {
        const uint32_t adder = faces.added_by(face);
        if (adder != kNone && !record_.is_sent(adder)) continue;
        const glm::u32vec3& leaves = faces.corners(face);
        const int at = faces.is_below(leaves.x, n) ? 0 : faces.is_below(leaves.y, n) ? 1 : 2;
        spokes_.push_back({active(leaves[(at + 1) % 3]), active(leaves[(at + 2) % 3])});
    }
    std::sort(spokes_.begin(), spokes_.end(), [](const Spoke& a, const Spoke& b) { return a.next < b.next; });
}

bool SentTree::is_lower(uint32_t v, uint32_t than) const {
    const glm::u32vec3 a = served_.model().exact_position(v), b = served_.model().exact_position(than);
    for (int i = 0; i != 3; ++i)
        if (a[i] != b[i]) return a[i] < b[i];
    return served_.faces().rank(v) < served_.faces().rank(than);
}

// Puts the spokes one behind the other, from that behind the boundary or that of the lowest neighbour on.
void SentTree::find_ring() {
    const uint32_t count = uint32_t(spokes_.size());
    const auto behind = [&](const Spoke& spoke) {
        const auto found = std::lower_bound(spokes_.begin(), spokes_.end(), spoke.previous,
                                            [](const Spoke& a, uint32_t v) { return a.next < v; });
        return found != spokes_.end() && found->next == spoke.previous ? uint32_t(found - spokes_.begin())
                                                                       : count;
    };
    ring_.clear();
    place_.is_closed = false;
    if (count == 0) return;
    is_behind_.assign(count, false);
    for (const Spoke& spoke : spokes_)
        if (const uint32_t next = behind(spoke); next != count) is_behind_[next] = true;
    uint32_t first = uint32_t(std::find(is_behind_.begin(), is_behind_.end(), false) - is_behind_.begin());
    place_.is_closed = first == count;
    if (place_.is_closed)
        first = uint32_t(
            std::min_element(spokes_.begin(), spokes_.end(),
                             [&](const Spoke& a, const Spoke& b) { return is_lower(a.next, b.next); }) -
            spokes_.begin());
    uint32_t at = first, last = first;
    for (uint32_t i = 0; i != count; ++i, last = std::exchange(at, behind(spokes_[at]))) {
        if (at == count || (at == first && i > 0)) fail();
        ring_.push_back(spokes_[at].next);
    }
    if (at != (place_.is_closed ? first : count)) fail();
    if (!place_.is_closed) ring_.push_back(spokes_[last].previous);
}

void SentTree::find_place(uint32_t n) {
    const Model& model = served_.model();
    place_.vertex = served_.vertex_data(tree_.kept[n]);
    place_.error = model.error_code(n), place_.radius = model.radius_code(n);
    find_spokes(n);
    find_ring();
    place_.ring.clear();
    for (const uint32_t v : ring_) place_.ring.push_back(model.exact_position(v));
}

int SentTree::position_of(uint32_t leaf) const {
    if (leaf == kNone) return -1;
    const auto found = std::find(ring_.begin(), ring_.end(), active(leaf));
    if (found == ring_.end()) fail();
    return int(found - ring_.begin());
}

// Equal ones are possible where it needs what was not sent.
Cuts SentTree::cuts(uint32_t n) const {
    const SplitFaces& faces = tree_.faces[n];
    return {position_of(faces.left_cut()), position_of(faces.right_cut())};
}

// ---- what is sent ----

void SentTree::send_split(RangeEncoder& encoder, uint32_t n, uint16_t& check) {
    find_place(n);
    SplitData split;
    split.cuts = cuts(n);
    split.vertex = served_.vertex_data(tree_.born_by(n));
    split.kept = served_.child_data(children_[n].kept);
    split.fresh = served_.child_data(children_[n].fresh);
    code_split(encoder, record_.models, served_.model().header(), tells_bounds(record_.service), place_,
               split);
    check = mixed(check, split.vertex);
    record_.add(n);
}

// The lowest common ancestor of the two cut vertices, as far as it has been split.
uint32_t SentTree::node_waited_for(uint32_t n) const {
    const SplitFaces& faces = tree_.faces[n];
    if (faces.left_cut() == kNone || faces.right_cut() == kNone) fail();
    uint32_t waited_for = split_apart(tree_, faces.left_cut(), faces.right_cut());
    while (waited_for != kNone && tree_.parent[waited_for] != kNone &&
           !record_.is_sent(tree_.parent[waited_for]))
        waited_for = tree_.parent[waited_for];
    return waited_for;
}

bool SentTree::send_cuts(RangeEncoder& encoder, uint32_t n) {
    const uint32_t waits_for = node_waited_for(n);
    if (record_.waits_for(n) == waits_for) return false;
    record_.wait_for(n, waits_for);
    find_place(n);
    code_decision(encoder, record_.models, Decision::cuts);
    code_cuts(encoder, place_.ring.size(), cuts(n));
    return true;
}

}  // namespace pm
