#include "pm/ring_mesh.h"

#include <algorithm>
#include <array>

#include "core/error.h"

namespace pm {

namespace {

uint32_t next(uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

uint32_t previous(uint32_t corner) {
    return corner % 3 == 0 ? corner + 2 : corner - 1;
}

[[noreturn]] void fail(const char* what) {
    throw core::Error(std::string("base mesh: ") + what);
}

}  // namespace

RingMesh::RingMesh(uint32_t vertex_count, std::vector<glm::u32vec3> faces)
    : faces_(std::move(faces)), opposite_(faces_.size(), glm::u32vec3(kNone)), corner_(vertex_count, kNone) {
    for (const glm::u32vec3& face : faces_) {
        if (glm::any(glm::greaterThanEqual(face, glm::u32vec3(vertex_count)))) fail("a corner is no vertex");
        if (face.x == face.y || face.y == face.z || face.z == face.x) fail("a face has two equal corners");
    }
    link_faces();
    // A vertex's corner is that behind the boundary, where there is one.
    for (uint32_t c = 0; c != 3 * uint32_t(faces_.size()); ++c) {
        uint32_t& first = corner_[vertex_at(c)];
        if (first == kNone || opposite_[previous(c) / 3][int(previous(c) % 3)] == kNone) first = c;
    }
    check_rings();
}

void RingMesh::link_faces() {
    struct Edge {
        uint64_t ends;  // the smaller vertex first
        uint32_t corner;
        bool is_rising;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * faces_.size());
    for (uint32_t c = 0; c != 3 * uint32_t(faces_.size()); ++c) {
        const uint64_t from = vertex_at(next(c)), to = vertex_at(previous(c));
        edges.push_back({std::min(from, to) << 32 | std::max(from, to), c, from < to});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return a.ends != b.ends ? a.ends < b.ends : a.corner < b.corner;
    });
    for (size_t i = 0; i + 1 < edges.size(); ++i) {
        if (edges[i].ends != edges[i + 1].ends) continue;
        if (edges[i].is_rising == edges[i + 1].is_rising) fail("two faces at an edge have one orientation");
        if (i + 2 < edges.size() && edges[i + 2].ends == edges[i].ends) fail("an edge has three faces");
        join(edges[i].corner, edges[i + 1].corner);
    }
}

void RingMesh::check_rings() const {
    size_t corners = 0;
    Ring ring;
    for (uint32_t v = 0; v != vertex_count(); ++v) {
        find_ring(v, ring);
        corners += ring.corners.size();
    }
    if (corners != 3 * faces_.size()) fail("a vertex has more than one ring");
}

void RingMesh::join(uint32_t a, uint32_t b) {
    if (a != kNone) opposite_[a / 3][int(a % 3)] = b;
    if (b != kNone) opposite_[b / 3][int(b % 3)] = a;
}

void RingMesh::find_ring(uint32_t vertex, Ring& ring) const {
    ring.neighbours.clear();
    ring.corners.clear();
    ring.is_closed = false;
    const uint32_t first = corner_[vertex];
    if (first == kNone) return;
    uint32_t c = first;
    for (;;) {
        ring.corners.push_back(c);
        ring.neighbours.push_back(vertex_at(next(c)));
        const uint32_t ahead = opposite_[next(c) / 3][int(next(c) % 3)];
        if (ahead == kNone) {
            ring.neighbours.push_back(vertex_at(previous(c)));
            return;
        }
        c = next(ahead);
        if (c == first) break;
    }
    ring.is_closed = true;
}

void RingMesh::split(uint32_t vertex, const Ring& ring, int left, int right) {
    const uint32_t fresh = vertex_count();
    const int count = int(ring.corners.size());
    corner_.push_back(kNone);
    // The corners that go to the new vertex: from that behind the left cut to that before the right one.
    const int begin = left < 0 ? 0 : left, end = right < 0 ? count : right;
    const int turns = ring.is_closed ? (end - begin + count) % count : 0;
    const auto moves = [&](int i) {
        if (ring.is_closed) return (i - begin + count) % count < turns;
        return begin <= end ? begin <= i && i < end : i < end || i >= begin;
    };
    const auto corner_behind = [&](int i) {  // kNone at the boundary
        return i < count ? ring.corners[size_t(i)] : kNone;
    };
    const auto corner_before = [&](int i) {
        if (i > 0) return ring.corners[size_t(i - 1)];
        return ring.is_closed ? ring.corners.back() : kNone;
    };
    for (int i = 0; i != count; ++i)
        if (moves(i)) at(ring.corners[size_t(i)]) = fresh;
    const uint32_t l = 3 * uint32_t(faces_.size()), r = l + 3;
    const uint32_t left_vertex = left < 0 ? kNone : ring.neighbours[size_t(left)];
    const uint32_t right_vertex = right < 0 ? kNone : ring.neighbours[size_t(right)];
    faces_.push_back(left < 0 ? glm::u32vec3(kNone) : glm::u32vec3(fresh, vertex, left_vertex));
    faces_.push_back(right < 0 ? glm::u32vec3(kNone) : glm::u32vec3(vertex, fresh, right_vertex));
    opposite_.resize(faces_.size(), glm::u32vec3(kNone));
    if (left >= 0) {
        const uint32_t before = corner_before(left), behind = corner_behind(left);
        join(l, before == kNone ? kNone : next(before));
        join(l + 1, behind == kNone ? kNone : previous(behind));
    }
    if (right >= 0) {
        const uint32_t before = corner_before(right), behind = corner_behind(right);
        join(r, before == kNone ? kNone : next(before));
        join(r + 1, behind == kNone ? kNone : previous(behind));
    }
    if (left >= 0 && right >= 0) join(l + 2, r + 2);
    // The corner of a vertex at the boundary is that behind it.
    const auto rewind = [&](uint32_t v, uint32_t corner) {
        for (uint32_t c = corner;;) {
            const uint32_t back = opposite_[previous(c) / 3][int(previous(c) % 3)];
            if (back == kNone || previous(back) == corner) {
                corner_[v] = back == kNone ? c : corner;
                return;
            }
            c = previous(back);
        }
    };
    if (left >= 0) {
        rewind(fresh, l), rewind(vertex, l + 1), rewind(left_vertex, l + 2);
    }
    if (right >= 0) {
        rewind(vertex, r), rewind(fresh, r + 1), rewind(right_vertex, r + 2);
    }
}

}  // namespace pm
