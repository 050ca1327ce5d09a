#include "pm/build/manifold.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/parallel.h"

namespace pm {

namespace {

// A directed edge by its corner: corner 3f + k of face f, from there to the next.
constexpr uint32_t next_corner(uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}
constexpr uint32_t previous_corner(uint32_t corner) {
    return corner % 3 == 0 ? corner + 2 : corner - 1;
}

struct EdgeEnd {
    uint32_t to;
    uint32_t corner;
    bool operator<(const EdgeEnd& other) const {
        return to != other.to ? to < other.to : corner < other.corner;
    }
};

class Cutter {
  public:
    Cutter(std::span<const glm::u32vec3> triangles, std::span<const glm::vec3> positions, Manifold& result)
        : result_(result),
          positions_(positions),
          input_count_(uint32_t(positions.size())),
          vertex_count_(input_count_) {
        result_.faces.assign(triangles.begin(), triangles.end());
        result_.source.resize(vertex_count_);
        std::iota(result_.source.begin(), result_.source.end(), 0u);
    }

    void run() {
        drop_duplicates();
        match_edges();
        split_fans();
        // Faces about an edge of four may still hang together at both of its ends: no copy of a vertex parts
        // them but one of their own.  After that no directed edge is left twice, and fans fall apart at most
        // once more.
        match_edges();
        if (detach_repeated_edges()) {
            match_edges();
            split_fans();
            match_edges();
        }
        drop_unreferenced();
        list_boundary();
    }

  private:
    uint32_t vertex(uint32_t corner) const { return result_.faces[corner / 3][corner % 3]; }
    void set_vertex(uint32_t corner, uint32_t v) { result_.faces[corner / 3][int(corner % 3)] = v; }
    uint32_t corner_count() const { return uint32_t(3 * result_.faces.size()); }

    // Entries of each vertex in a run of their own, sorted.
    template <class Key>
    void group(std::vector<uint32_t>& begin, std::vector<EdgeEnd>& ends, uint32_t count, const Key& key_of) {
        begin.assign(size_t(vertex_count_) + 2, 0);
        for (uint32_t c = 0; c < count; ++c) ++begin[size_t(key_of(c).first) + 2];
        for (size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
        ends.resize(count);
        for (uint32_t c = 0; c < count; ++c) {
            const auto [from, to] = key_of(c);
            ends[begin[size_t(from) + 1]++] = {to, c};
        }
        core::parallel_for(
            vertex_count_, [&](size_t v) { std::sort(ends.begin() + begin[v], ends.begin() + begin[v + 1]); },
            4096);
    }

    // Faces with the same corners in the same sense, by their smallest corner first.
    void drop_duplicates() {
        const auto turned = [&](uint32_t f) {
            const glm::u32vec3 face = result_.faces[f];
            const int k = face.x < face.y ? (face.x < face.z ? 0 : 2) : (face.y < face.z ? 1 : 2);
            return glm::u32vec3(face[k], face[(k + 1) % 3], face[(k + 2) % 3]);
        };
        std::vector<uint32_t> begin;
        std::vector<EdgeEnd> ends;
        group(begin, ends, uint32_t(result_.faces.size()), [&](uint32_t f) {
            const glm::u32vec3 face = turned(f);
            return std::pair(face.x, face.y);
        });
        std::vector<uint8_t> is_dropped(result_.faces.size(), 0);
        core::parallel_for(
            vertex_count_,
            [&](size_t v) {
                std::vector<EdgeEnd> thirds;
                for (uint32_t i = begin[v]; i < begin[v + 1];) {
                    thirds.clear();
                    uint32_t j = i;
                    for (; j < begin[v + 1] && ends[j].to == ends[i].to; ++j)
                        thirds.push_back({turned(ends[j].corner).z, ends[j].corner});
                    if (thirds.size() > 1) std::sort(thirds.begin(), thirds.end());
                    for (size_t k = 1; k < thirds.size(); ++k)
                        is_dropped[thirds[k].corner] = thirds[k].to == thirds[k - 1].to;
                    i = j;
                }
            },
            4096);
        size_t kept = 0;
        for (size_t f = 0; f < result_.faces.size(); ++f)
            if (!is_dropped[f]) result_.faces[kept++] = result_.faces[f];
        result_.duplicate_faces = result_.faces.size() - kept;
        result_.faces.resize(kept);
    }

    // opposite_: the corner whose edge runs against that of a corner, or kNone at a boundary and where it is
    // not clear.
    void match_edges() {
        std::vector<uint32_t> begin;
        std::vector<EdgeEnd> ends;
        group(begin, ends, corner_count(), [&](uint32_t c) {
            const uint32_t a = vertex(c), b = vertex(next_corner(c));
            return std::pair(std::min(a, b), std::max(a, b));
        });
        opposite_.assign(corner_count(), kNone);
        repeated_.clear();
        uint64_t cut = 0;
        for (uint32_t v = 0; v < vertex_count_; ++v)
            for (uint32_t i = begin[v]; i < begin[v + 1];) {
                uint32_t j = i + 1;
                while (j < begin[v + 1] && ends[j].to == ends[i].to) ++j;
                const uint32_t a = ends[i].corner, b = ends[j - 1].corner;
                if (j - i == 2 && vertex(a) != vertex(b))
                    opposite_[a] = b, opposite_[b] = a;
                else if (j - i > 1)
                    ++cut, pair_by_angle({ends.data() + i, j - i}), note_repeated({ends.data() + i, j - i});
                i = j;
            }
        if (result_.cut_edges == 0) result_.cut_edges = cut;
    }

    // An edge of one pair of vertices and the angle of its face about the line through them.
    struct Wing {
        double angle;
        bool is_forward;  // from the lower vertex
        uint32_t corner;
        // Of two faces in one place the backward one comes first: they are a flap, back to back.
        bool operator<(const Wing& o) const {
            return std::tie(angle, is_forward, corner) < std::tie(o.angle, o.is_forward, o.corner);
        }
    };

    void pair_by_angle(std::span<const EdgeEnd> edges) {
        const auto place = [&](uint32_t v) { return glm::dvec3(positions_[result_.source[v]]); };
        const uint32_t low = std::min(vertex(edges[0].corner), vertex(next_corner(edges[0].corner)));
        const glm::dvec3 at = place(low), axis = place(edges[0].to) - at;
        const glm::dvec3 size = glm::abs(axis);
        const glm::dvec3 aside(size.x <= size.y && size.x <= size.z, size.x > size.y && size.y <= size.z,
                               size.x > size.z && size.y > size.z);
        const glm::dvec3 u = glm::cross(axis, aside), w = glm::cross(axis, u);
        const double by_length = glm::length(axis);
        std::vector<Wing> wings;
        for (const EdgeEnd& e : edges) {
            const glm::dvec3 third = place(vertex(previous_corner(e.corner))) - at;
            wings.push_back({turn_of(glm::dot(third, u) * by_length, glm::dot(third, w)),
                             vertex(e.corner) == low, e.corner});
        }
        std::sort(wings.begin(), wings.end());
        // The inside of a solid is before a face that runs forward and behind one that runs backward.  Twice
        // round: what begins before the first angle ends behind it.
        std::vector<uint32_t> open;
        for (size_t i = 0; i < 2 * wings.size(); ++i) {
            const Wing& wing = wings[i % wings.size()];
            if (opposite_[wing.corner] != kNone) continue;
            if (!wing.is_forward) {
                if (i < wings.size()) open.push_back(wing.corner);
            } else if (!open.empty()) {
                opposite_[wing.corner] = open.back(), opposite_[open.back()] = wing.corner;
                open.pop_back();
            }
        }
    }

    // Rises with the angle of (x, y), from 0 to 4.
    static double turn_of(double x, double y) {
        const double sum = std::fabs(x) + std::fabs(y);
        if (!(sum > 0)) return 0;
        return y >= 0 ? 1 - x / sum : 3 + x / sum;
    }

    // Of the edges of a pair of vertices: all but the first of each direction.
    void note_repeated(std::span<const EdgeEnd> edges) {
        uint32_t seen[2] = {};
        for (const EdgeEnd& e : edges)
            if (seen[vertex(e.corner) < vertex(next_corner(e.corner))]++ > 0) repeated_.push_back(e.corner);
    }

    bool detach_repeated_edges() {
        for (const uint32_t corner : repeated_) set_vertex(corner, copy_of(vertex(corner)));
        return !repeated_.empty();
    }

    uint32_t copy_of(uint32_t v) {
        result_.source.push_back(result_.source[v]);
        return vertex_count_++;
    }

    // One vertex for each fan: the first keeps its number.
    void split_fans() {
        std::vector<uint8_t> is_taken(vertex_count_, 0), is_done(corner_count(), 0);
        const uint32_t count = corner_count();
        for (uint32_t c = 0; c < count; ++c) {
            if (is_done[c]) continue;
            const uint32_t old = vertex(c);
            uint32_t v = old;
            if (is_taken[old])
                v = copy_of(old);
            else
                is_taken[old] = 1;
            // Both ways round, as far as edges match.  A fan that is closed is gone round once.
            for (uint32_t at = c; at != kNone && !is_done[at]; at = opposite_[previous_corner(at)])
                is_done[at] = 1, set_vertex(at, v);
            for (uint32_t across = opposite_[c]; across != kNone;) {
                const uint32_t at = next_corner(across);
                if (is_done[at]) break;
                is_done[at] = 1, set_vertex(at, v);
                across = opposite_[at];
            }
        }
    }

    void drop_unreferenced() {
        std::vector<uint32_t> number(vertex_count_, kNone);
        for (const glm::u32vec3& face : result_.faces)
            for (int k = 0; k < 3; ++k) number[face[k]] = 0;
        uint32_t used = 0;
        std::vector<uint32_t> first(result_.source.size(), kNone);  // by vertex of the input
        for (uint32_t v = 0; v < vertex_count_; ++v) {
            if (number[v] == kNone) continue;
            const uint32_t source = result_.source[v];
            number[v] = used;
            if (first[source] == kNone)
                first[source] = used;
            else
                result_.welds.push_back({used, first[source]});
            result_.source[used++] = source;
        }
        result_.unreferenced = uint64_t(std::count(first.begin(), first.begin() + input_count_, kNone));
        result_.source.resize(used);
        for (glm::u32vec3& face : result_.faces)
            for (int k = 0; k < 3; ++k) face[k] = number[face[k]];
    }

    void list_boundary() {
        for (uint32_t c = 0; c < corner_count(); ++c)
            if (opposite_[c] == kNone) result_.boundary.emplace_back(vertex(c), vertex(next_corner(c)));
    }

    Manifold& result_;
    std::span<const glm::vec3> positions_;  // of the input
    const uint32_t input_count_;
    uint32_t vertex_count_;
    std::vector<uint32_t> opposite_, repeated_;
};

}  // namespace

Manifold make_manifold(std::span<const glm::u32vec3> triangles, std::span<const glm::vec3> positions) {
    Manifold result;
    Cutter(triangles, positions, result).run();
    return result;
}

double widest_gap(const Manifold& surface, std::span<const glm::dvec3> positions) {
    std::vector<uint32_t> up(positions.size());
    std::iota(up.begin(), up.end(), 0u);
    const auto find = [&](uint32_t v) {
        while (up[v] != v) v = up[v] = up[up[v]];
        return v;
    };
    for (const glm::u32vec2& e : surface.boundary) {
        const uint32_t a = find(e.x), b = find(e.y);
        up[std::max(a, b)] = std::min(a, b);
    }
    std::vector<glm::dvec3> low(positions.begin(), positions.end()), high = low;
    for (const glm::u32vec2& e : surface.boundary) {
        const uint32_t root = find(e.x);
        low[root] = glm::min(low[root], positions[e.x]), high[root] = glm::max(high[root], positions[e.x]);
    }
    double widest = 0;
    for (const glm::u32vec2& e : surface.boundary) {
        const uint32_t root = find(e.x);
        widest = std::max(widest, glm::length(high[root] - low[root]));
    }
    return widest;
}

}  // namespace pm
