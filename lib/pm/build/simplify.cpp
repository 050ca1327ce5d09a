#include "pm/build/simplify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "core/parallel_sort.h"
#include "core/stopwatch.h"
#include "pm/bounds.h"
#include "pm/build/quadric.h"
#include "pm/format.h"

namespace pm {

namespace {

constexpr double kFlipCosine = 0.2;  // of a face before and after one collapse
constexpr double kShare =
    0.5;  // of the candidates that enter a pass: as true to error as a twentieth, cheaper
constexpr double kStall = 0.01;  // of the vertices: a pass that does less is the last of its kind
constexpr double kBoundaryWeight =
    1;  // of the plane that stands on a boundary edge, to the square of its length
constexpr double kNever = std::numeric_limits<double>::infinity();

// Where a vertex may go: cheapest first, and then by number.
struct Target {
    double cost = kNever;
    uint32_t vertex = kNone;
    bool operator<(const Target& o) const { return cost != o.cost ? cost < o.cost : vertex < o.vertex; }
};

struct Candidate {
    double cost;
    uint32_t vertex;
    bool operator<(const Candidate& o) const { return cost != o.cost ? cost < o.cost : vertex < o.vertex; }
};

glm::dvec3 scaled_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::cross(b - a, c - a);
}

// The faces about a vertex are one fan.  It is closed where its neighbours come next as often as they come
// before; of an open one the first does not come before and the last not next, which no sum hides.
bool is_open(std::span<const Spoke> ring) {
    uint32_t difference = 0;
    for (const Spoke& s : ring) difference += s.next - s.previous;
    return difference != 0;
}

// Calls use(u, spoke) for both ends of an open fan.
template <class Use>
void for_ends(std::span<const Spoke> ring, const Use& use) {
    std::vector<std::pair<uint32_t, size_t>> nexts, previous;  // sorted: there may be many
    for (size_t i = 0; i < ring.size(); ++i)
        nexts.emplace_back(ring[i].next, i), previous.emplace_back(ring[i].previous, i);
    std::sort(nexts.begin(), nexts.end());
    std::sort(previous.begin(), previous.end());
    const auto use_alone = [&](const auto& these, const auto& others) {
        for (const auto& [v, i] : these) {
            const auto other = std::lower_bound(others.begin(), others.end(), std::pair(v, size_t(0)));
            if (other == others.end() || other->first != v) use(v, ring[i]);
        }
    };
    use_alone(nexts, previous);
    use_alone(previous, nexts);
}

// Neighbours with more leaves below them are not charged for: their own errors are large enough, and it would
// cost 10 % more splits of the dragon for nothing.
constexpr uint32_t kMostLeaves = 32;

class Simplifier {
  public:
    Simplifier(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
               const SimplifyOptions& options)
        : positions_(positions), options_(options) {
        result_.faces.assign(faces.begin(), faces.end());
        result_.collapses.reserve(positions.size());
        live_faces_.resize(faces.size());
        std::iota(live_faces_.begin(), live_faces_.end(), 0u);
        live_vertices_.resize(positions.size());
        std::iota(live_vertices_.begin(), live_vertices_.end(), 0u);
    }

    SimplifyResult run(const std::function<void(uint64_t)>& progress) {
        core::Stopwatch watch;
        rings_.build(result_.faces, live_faces_, live_vertices_, positions_.size());
        result_.collapse_ms += watch.lap_ms();
        supports_.emplace(positions_, result_.faces.size(), rings_);
        result_.support_ms += watch.lap_ms();
        set_quadrics();
        if (options_.flip_test) set_input_normals();
        prepare();
        for (bool is_last = false;;) {
            const size_t first = result_.collapses.size();
            run_pass(is_last ? 1 : kShare);
            const size_t done = result_.collapses.size() - first;
            if (is_last && done == 0) break;
            is_last = is_last || double(done) < kStall * double(live_vertices_.size());
            ++result_.passes;
            compact();
            rings_.build(result_.faces, live_faces_, live_vertices_, positions_.size());
            result_.collapse_ms += watch.lap_ms();
            measure_from(first);
            result_.support_ms += watch.lap_ms();
            if (progress) progress(result_.collapses.size());
        }
        result_.base_faces = std::move(live_faces_);
        result_.base_vertices = std::move(live_vertices_);
        return std::move(result_);
    }

  private:
    void set_quadrics() {
        quadrics_.resize(positions_.size());
        own_cost_.resize(positions_.size());
        core::parallel_for(
            positions_.size(),
            [&](size_t i) {
                const auto v = uint32_t(i);
                const glm::dvec3 at = positions_[v];
                const auto ring = rings_[v];
                const auto normal_of = [&](const Spoke& s) {
                    return scaled_normal(at, positions_[s.next], positions_[s.previous]);
                };
                for (const Spoke& s : ring) {
                    const glm::dvec3 normal = normal_of(s);
                    const double length = glm::length(normal);
                    if (length > 0) quadrics_[v] += Quadric::plane(normal / length, at, length);
                }
                const auto stand_on = [&](uint32_t end, const Spoke& s) {
                    const glm::dvec3 edge = positions_[end] - at;
                    const glm::dvec3 across = glm::cross(edge, normal_of(s));
                    const double length = glm::length(across);
                    if (length > 0)
                        quadrics_[v] +=
                            Quadric::plane(across / length, at, kBoundaryWeight * glm::dot(edge, edge));
                };
                if (is_open(ring)) for_ends(ring, stand_on);
                own_cost_[v] = quadrics_[v](at);
            },
            1024);
    }

    void set_input_normals() {
        input_normals_.resize(result_.faces.size());
        core::parallel_for(
            result_.faces.size(),
            [&](size_t f) {
                const glm::u32vec3 face = result_.faces[f];
                input_normals_[f] =
                    encode_normal(scaled_normal(positions_[face.x], positions_[face.y], positions_[face.z]));
            },
            4096);
    }

    void prepare() {
        best_.resize(positions_.size());
        is_dirty_.assign(positions_.size(), 1);
        is_locked_.assign(positions_.size(), 0);
        is_gone_.assign(positions_.size(), 0);
        mark_.assign(positions_.size(), 0);
        face_count_.resize(positions_.size());
        for (const uint32_t v : live_vertices_) face_count_[v] = uint32_t(rings_[v].size());
    }

    // The cheapest target of `v` behind `tried`.  A vertex at a boundary moves along it.
    Target cheapest(uint32_t v, const Target& tried) const {
        Target best;
        const auto consider = [&](uint32_t u) {
            const Target target{quadrics_[v](positions_[u]) + own_cost_[u], u};
            if (tried < target && target < best) best = target;
        };
        if (is_open(rings_[v]))
            for_ends(rings_[v], [&](uint32_t u, const Spoke&) { consider(u); });
        else
            for (const Spoke& s : rings_[v]) consider(s.next);
        return best;
    }

    void find_targets() {
        core::parallel_for(
            live_vertices_.size(),
            [&](size_t i) {
                const uint32_t v = live_vertices_[i];
                if (!is_dirty_[v]) return;
                best_[v] = cheapest(v, {-1, kNone});
                is_dirty_[v] = 0;
            },
            1024);
    }

    // The cheapest `share` of the candidates, sorted.
    std::vector<Candidate> candidates(double share) {
        std::vector<Candidate> list;
        list.reserve(live_vertices_.size());
        for (const uint32_t v : live_vertices_)
            if (best_[v].cost < kNever) list.push_back({best_[v].cost, v});
        const auto wanted = size_t(std::ceil(share * double(list.size())));
        if (wanted < list.size()) {
            std::nth_element(list.begin(), list.begin() + ptrdiff_t(wanted), list.end());
            list.resize(wanted);
        }
        core::parallel_sort(list.begin(), list.end());
        return list;
    }

    void run_pass(double share) {
        supports_->begin_pass();
        find_targets();
        const std::vector<Candidate> list = candidates(share);
        const double limit = list.empty() ? 0 : list.back().cost;
        for (const Candidate& candidate : list)
            if (!is_locked_[candidate.vertex]) try_targets(candidate.vertex, limit);
    }

    // What is refused is not tried again until something about the vertex has changed.
    void try_targets(uint32_t v, double limit) {
        bool is_blocked = false;  // by a lock: the target may be free in the next pass
        Target target = best_[v];
        for (; target.cost <= limit; target = cheapest(v, target)) {
            if (is_locked_[target.vertex]) {
                if (!is_blocked) best_[v] = target;
                is_blocked = true;
                continue;
            }
            if (!is_legal(v, target.vertex)) continue;
            collapse(v, target.vertex);
            return;
        }
        if (!is_blocked) best_[v] = target;
    }

    // Link condition: v and u have no other neighbours in common than the corners of the faces at their edge.
    bool is_legal(uint32_t v, uint32_t u) {
        const auto ring = rings_[v];
        uint32_t left = kNone, right = kNone;  // corners opposite to the edge
        for (const Spoke& s : ring) {
            if (s.next == u) left = s.previous;
            if (s.previous == u) right = s.next;
        }
        const uint32_t edge_faces = uint32_t(left != kNone) + uint32_t(right != kNone);
        // What is left has faces: at the kept vertex, and at the cuts, of which each loses one.
        const auto keeps_a_face = [&](uint32_t cut) { return cut == kNone || face_count_[cut] > 1; };
        if (face_count_[u] <= edge_faces || !keeps_a_face(left) || !keeps_a_face(right) ||
            common_neighbours(v, u) != edge_faces || leaves_a_double(v, u, left, right)) {
            ++result_.refused_links;
            return false;
        }
        if (options_.flip_test && flips(v, u)) {
            ++result_.refused_flips;
            return false;
        }
        return true;
    }

    // Marks of stamp_ and stamp_ + 1 are of nothing yet.
    void begin_marks() {
        if (stamp_ > std::numeric_limits<uint32_t>::max() - 3) {
            std::fill(mark_.begin(), mark_.end(), 0u);
            stamp_ = 0;
        }
        stamp_ += 2;
    }

    uint32_t common_neighbours(uint32_t v, uint32_t u) {
        begin_marks();
        for (const Spoke& s : rings_[v]) mark_[s.next] = mark_[s.previous] = stamp_;
        uint32_t common = 0;
        const auto count = [&](uint32_t w) {
            if (mark_[w] == stamp_) mark_[w] = stamp_ + 1, ++common;
        };
        for (const Spoke& s : rings_[u]) count(s.next), count(s.previous);
        return common;
    }

    // A vertex with three faces round it leaves one where they were.  That face may be there already, turned:
    // of a tetrahedron two faces back to back would be left.
    bool leaves_a_double(uint32_t v, uint32_t u, uint32_t left, uint32_t right) const {
        if (rings_[v].size() != 3 || left == kNone || right == kNone) return false;
        return std::any_of(rings_[u].begin(), rings_[u].end(), [&](const Spoke& s) {
            return (s.next == left && s.previous == right) || (s.next == right && s.previous == left);
        });
    }

    bool flips(uint32_t v, uint32_t u) const {
        const glm::dvec3 from = positions_[v], to = positions_[u];
        for (const Spoke& s : rings_[v]) {
            if (s.next == u || s.previous == u) continue;
            const glm::dvec3 b = positions_[s.next], c = positions_[s.previous];
            const glm::dvec3 before = scaled_normal(from, b, c), after = scaled_normal(to, b, c);
            const double before2 = glm::dot(before, before), after2 = glm::dot(after, after);
            if (before2 == 0) continue;  // nothing to turn
            if (!(glm::dot(before, after) > kFlipCosine * std::sqrt(before2 * after2))) return true;
            if (glm::dot(after, decode_normal(input_normals_[s.corner / 3])) < 0) return true;
        }
        return false;
    }

    void collapse(uint32_t v, uint32_t u) {
        Collapse c{v, u, kNone, kNone, {}};
        for (const Spoke& s : rings_[v]) {
            is_locked_[s.next] = is_locked_[s.previous] = 1;
            supports_->change(s.corner / 3);
            if (s.next == u) c.left_corner = s.corner, --face_count_[s.previous];
            if (s.previous == u) c.right_corner = s.corner, --face_count_[s.next];
            if (s.next != u && s.previous != u)
                result_.faces[s.corner / 3][int(s.corner % 3)] = u, ++face_count_[u];
            else
                --face_count_[u];
        }
        is_locked_[v] = is_gone_[v] = 1;
        quadrics_[u] += quadrics_[v];
        own_cost_[u] = quadrics_[u](positions_[u]);
        supports_->join(v, u);
        result_.collapses.push_back(c);
    }

    bool is_there(uint32_t f) const {
        const glm::u32vec3 face = result_.faces[f];
        return !is_gone_[face.x] && !is_gone_[face.y] && !is_gone_[face.z];
    }

    // Faces that vanished keep their corners, of which one is gone.
    void compact() {
        std::erase_if(live_faces_, [&](uint32_t f) { return !is_there(f); });
        for (const uint32_t v : live_vertices_) is_locked_[v] = 0;
        std::erase_if(live_vertices_, [&](uint32_t v) {
            if (is_gone_[v]) rings_.clear(v);
            return is_gone_[v] != 0;
        });
    }

    // What changes about a vertex: its faces, and the quadrics of its neighbours.
    void measure_from(size_t first) {
        const auto fresh = std::span(result_.collapses).subspan(first);
        core::parallel_for(
            fresh.size(),
            [&](size_t i) { fresh[i].support = supports_->measure(fresh[i].kept, result_.faces, rings_); },
            32);
        for (const Collapse& c : fresh) {
            is_dirty_[c.kept] = 1;
            for (const Spoke& s : rings_[c.kept]) is_dirty_[s.next] = is_dirty_[s.previous] = 1;
        }
        charge_neighbours(fresh);
    }

    // A collapse also moves the surface away from leaves below its neighbours.  That is its own error, since
    // what split the neighbour long ago knows nothing of it: without this, where a view stops, one leaf in a
    // hundred is farther off than its tolerance (the armadillo from near; with it, one in three thousand).
    void charge_neighbours(std::span<Collapse> fresh) {
        std::vector<uint32_t> neighbours;
        begin_marks();
        const auto list = [&](uint32_t v) {
            if (mark_[v] == stamp_ || supports_->leaves(v) > kMostLeaves) return;
            mark_[v] = stamp_;
            neighbours.push_back(v);
        };
        for (const Collapse& c : fresh)
            for (const Spoke& s : rings_[c.kept]) list(s.next), list(s.previous);
        core::parallel_for(
            neighbours.size(),
            [&](size_t i) {
                const uint32_t v = neighbours[i];
                const double error = supports_->worst_error(v, result_.faces, rings_);
                if (!(error > supports_->error(v))) return;
                supports_->set_error(v, error);
                mark_[v] = stamp_ + 1;
            },
            32);
        for (Collapse& c : fresh) {
            const auto charge = [&](uint32_t v) {
                if (mark_[v] == stamp_ + 1)
                    c.support.neighbours_error = std::max(c.support.neighbours_error, supports_->error(v));
            };
            for (const Spoke& s : rings_[c.kept]) charge(s.next), charge(s.previous);
            c.support.error = std::max(c.support.error, c.support.neighbours_error);
        }
    }

    std::span<const glm::dvec3> positions_;
    const SimplifyOptions& options_;
    SimplifyResult result_;
    std::vector<uint32_t> live_faces_, live_vertices_;
    Rings rings_;
    std::optional<Supports> supports_;
    std::vector<Quadric> quadrics_;
    std::vector<double> own_cost_;         // of a vertex where it is
    std::vector<uint16_t> input_normals_;  // coded: a degree does not matter
    std::vector<Target> best_;
    std::vector<uint8_t> is_dirty_, is_locked_, is_gone_;
    std::vector<uint32_t> face_count_;  // as it is, not as it was when the pass began
    std::vector<uint32_t> mark_;
    uint32_t stamp_ = 0;
};

}  // namespace

SimplifyResult simplify(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
                        const SimplifyOptions& options, const std::function<void(uint64_t)>& progress) {
    return Simplifier(positions, faces, options).run(progress);
}

}  // namespace pm
