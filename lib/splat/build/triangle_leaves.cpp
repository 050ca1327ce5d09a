#include "splat/build/triangle_leaves.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "splat/corner_normal.h"
#include "splat/format.h"

namespace splat {

namespace {

constexpr size_t kPiece = size_t(1) << 14;
// Five hundred steps and more to a radius: corners are off by a 20th of a pixel where it is 50 pixels wide,
// and take half the bytes of single precision.
constexpr double kMiddleSteps = 512, kSmallSteps = 64;
constexpr double kLeastBits = 16;  // steps are well below the 1e-4 by which the root is larger than the mesh

template <class Sum>
Sum sum_of(const std::vector<Sum>& parts) {
    Sum sum{};
    for (const Sum& part : parts) sum += part;
    return sum;
}

uint32_t choose_lattice_bits(const mesh::Mesh& mesh, const Placement& placement) {
    constexpr size_t kSamples = size_t(1) << 16;
    const size_t stride = std::max<size_t>(1, mesh.triangles.size() / kSamples);
    std::vector<double> radii;
    for (size_t t = 0; t < mesh.triangles.size(); t += stride) {
        glm::dvec3 corner[3];
        for (int k = 0; k < 3; ++k)
            corner[k] = (glm::dvec3(mesh.positions[mesh.triangles[t][k]]) + placement.offset) *
                        placement.inverse_scale;
        if (const double radius = smallest_circle(corner[0], corner[1], corner[2]).radius; radius > 0)
            radii.push_back(radius);
    }
    if (radii.empty()) return kMaxLatticeBits;
    std::sort(radii.begin(), radii.end());
    const double finest =
        std::min(radii[radii.size() / 2] / kMiddleSteps, radii[radii.size() / 50] / kSmallSteps);
    return uint32_t(std::clamp(std::ceil(-std::log2(finest)), kLeastBits, double(kMaxLatticeBits)));
}

uint64_t mix(uint64_t x) {
    x *= 0x9e3779b97f4a7c15u;
    return x ^ x >> 29;
}
template <class V>
uint64_t hash_of(const V& v) {
    uint64_t h = 0;
    for (int k = 0; k < 3; ++k) {
        uint32_t word;
        const auto value = v[k] + 0;  // -0 is 0
        std::memcpy(&word, &value, sizeof(word));
        h = mix(h + word + 1);
    }
    return h ^ h >> 32;
}

// How many different values there are among the items that are used.
template <class Value>
uint64_t count_different(const std::vector<Value>& values, std::span<const uint8_t> is_used) {
    const size_t count = values.size();
    constexpr uint32_t kEmpty = ~0u;
    size_t size = 16;
    while (size < 2 * count) size *= 2;
    std::vector<uint32_t> table(size, kEmpty);
    std::vector<uint64_t> added((count + kPiece - 1) / kPiece, 0);
    core::parallel_pieces(count, kPiece, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            if (!is_used[i]) continue;
            for (size_t slot = hash_of(values[i]) & (size - 1);; slot = (slot + 1) & (size - 1)) {
                uint32_t found = kEmpty;
                const bool is_new =
                    std::atomic_ref(table[slot])
                        .compare_exchange_strong(found, uint32_t(i), std::memory_order_relaxed);
                added[begin / kPiece] += is_new;
                if (is_new || values[i] == values[found]) break;
            }
        }
    });
    return sum_of(added);
}

bool has_area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 p = b - a, q = c - a, n = glm::cross(p, q);
    return glm::dot(n, n) > 1e-24 * glm::dot(p, p) * glm::dot(q, q);
}

}  // namespace

TriangleCircle smallest_circle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    using Kind = TriangleCircle::Kind;
    const glm::dvec3 p[3] = {a, b, c};
    double square[3];  // of the side opposite to each corner
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 side = p[(k + 2) % 3] - p[(k + 1) % 3];
        square[k] = glm::dot(side, side);
    }
    const int far = int(std::max_element(square, square + 3) - square);
    const glm::dvec3 &from = p[(far + 1) % 3], &to = p[(far + 2) % 3];
    const Kind kind = has_area(a, b, c) ? Kind::obtuse : Kind::degenerate;
    if (kind == Kind::degenerate || 2 * square[far] >= square[0] + square[1] + square[2])
        return {from + 0.5 * (to - from), 0.5 * std::sqrt(square[far]), kind};
    const glm::dvec3 u = b - a, v = c - a, n = glm::cross(u, v);
    const glm::dvec3 off =
        (square[1] * glm::cross(n, u) + square[2] * glm::cross(v, n)) * (0.5 / glm::dot(n, n));
    return {a + off, glm::length(off), Kind::acute};
}

TriangleLeaves make_triangle_leaves(mesh::Mesh& mesh, std::span<const uint8_t> is_used,
                                    const Placement& placement, std::vector<TreePoint>& leaves,
                                    TriangleCounts& counts) {
    TriangleLeaves out;
    out.lattice_bits = choose_lattice_bits(mesh, placement);
    out.step = std::ldexp(1.0, -int(out.lattice_bits));
    const double steps = std::ldexp(1.0, int(out.lattice_bits));
    out.corners.resize(mesh.positions.size());
    out.normals.resize(mesh.positions.size());
    out.normals_are_given = !mesh.normals.empty();
    core::parallel_pieces(mesh.positions.size(), kPiece, [&](size_t begin, size_t end) {
        for (size_t v = begin; v < end; ++v) {
            const glm::dvec3 at =
                (glm::dvec3(mesh.positions[v]) + placement.offset) * placement.inverse_scale;
            // Vertices of no triangle may be anywhere.
            for (int k = 0; k < 3; ++k)
                out.corners[v][k] = int(std::lround(std::clamp(at[k], -1.0, 1.0) * steps));
            if (out.normals_are_given) out.normals[v] = encode_corner_normal(glm::dvec3(mesh.normals[v]));
        }
    });
    const uint64_t points = count_different(out.corners, is_used);
    if (points < mesh.positions.size())
        counts.merged_vertices = count_different(mesh.positions, is_used) - points;
    out.triangles = std::move(mesh.triangles);
    out.is_smooth.resize(out.triangles.size());
    leaves.resize(out.triangles.size());
    std::vector<TriangleCounts> parts((leaves.size() + kPiece - 1) / kPiece);
    core::parallel_pieces(leaves.size(), kPiece, [&](size_t begin, size_t end) {
        TriangleCounts& part = parts[begin / kPiece];
        for (size_t t = begin; t < end; ++t) {
            const glm::u32vec3 v = out.triangles[t];
            const TriangleCircle circle = smallest_circle(out.at(v.x), out.at(v.y), out.at(v.z));
            leaves[t] = {glm::vec3(circle.centre), uint32_t(t)};
            part.acute += circle.kind == TriangleCircle::Kind::acute;
            part.obtuse += circle.kind == TriangleCircle::Kind::obtuse;
            if (circle.kind != TriangleCircle::Kind::degenerate) continue;
            ++part.degenerate;
            part.flattened += has_area(glm::dvec3(mesh.positions[v.x]), glm::dvec3(mesh.positions[v.y]),
                                       glm::dvec3(mesh.positions[v.z]));
        }
    });
    for (const TriangleCounts& part : parts) {
        counts.acute += part.acute, counts.obtuse += part.obtuse;
        counts.degenerate += part.degenerate, counts.flattened += part.flattened;
    }
    std::vector<glm::vec3>().swap(mesh.positions);
    return out;
}

TriangleNeighbours::TriangleNeighbours(const TriangleLeaves& leaves, std::span<const TreePoint> points,
                                       std::span<const uint32_t> subtree_begin)
    : leaves_(leaves), points_(points), subtree_begin_(subtree_begin), is_shared_(leaves.corners.size(), 0) {
    // In a soup of triangles about one vertex all subtrees would want to see all.
    constexpr size_t kMostSharers = 6;
    const size_t subtrees = subtree_begin.size();
    strangers_.resize(subtrees);
    if (subtrees < 2) return;
    find_sharers(subtrees);
    std::vector<std::vector<Sharer>> wanted(subtrees);  // `vertex` is a triangle here
    core::parallel_for(subtrees, [&](size_t s) {
        for_triangles(s, [&](uint32_t triangle) {
            const size_t first = wanted[s].size();
            for (int k = 0; k < 3; ++k) {
                const uint32_t vertex = leaves_.triangles[triangle][k];
                if (!is_shared_[vertex]) continue;
                std::span<const Sharer> sharers = sharers_of(vertex);
                if (sharers.size() > kMostSharers) sharers = sharers.first(1);
                for (const Sharer& other : sharers) {
                    const Sharer want{triangle, other.subtree};
                    if (other.subtree != s && std::find(wanted[s].begin() + ptrdiff_t(first), wanted[s].end(),
                                                        want) == wanted[s].end())
                        wanted[s].push_back(want);
                }
            }
        });
    });
    for (const std::vector<Sharer>& wants : wanted)
        for (const Sharer& want : wants) strangers_[want.subtree].push_back(want.vertex);
}

template <class Use>
void TriangleNeighbours::for_triangles(size_t subtree, const Use& use) const {
    const size_t end = subtree + 1 < subtree_begin_.size() ? subtree_begin_[subtree + 1] : points_.size();
    for (size_t i = subtree_begin_[subtree]; i < end; ++i) use(points_[i].vertex);
}

void TriangleNeighbours::find_sharers(size_t subtrees) {
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> first(leaves_.corners.size(),
                                kNone);  // who came first is chance, that others came is not
    core::parallel_for(subtrees, [&](size_t s) {
        for_triangles(s, [&](uint32_t triangle) {
            for (int k = 0; k < 3; ++k) {
                const uint32_t vertex = leaves_.triangles[triangle][k];
                uint32_t found = std::atomic_ref(first[vertex]).load(std::memory_order_relaxed);
                if (found == kNone)
                    std::atomic_ref(first[vertex])
                        .compare_exchange_strong(found, uint32_t(s), std::memory_order_relaxed);
                if (found != kNone && found != s)
                    std::atomic_ref(is_shared_[vertex]).store(1, std::memory_order_relaxed);
            }
        });
    });
    std::vector<std::vector<Sharer>> found(subtrees);
    core::parallel_for(subtrees, [&](size_t s) {
        for_triangles(s, [&](uint32_t triangle) {
            for (int k = 0; k < 3; ++k)
                if (const uint32_t vertex = leaves_.triangles[triangle][k]; is_shared_[vertex])
                    found[s].push_back({vertex, uint32_t(s)});
        });
        std::sort(found[s].begin(), found[s].end());
        found[s].erase(std::unique(found[s].begin(), found[s].end()), found[s].end());
    });
    for (const std::vector<Sharer>& f : found) sharers_.insert(sharers_.end(), f.begin(), f.end());
    std::sort(sharers_.begin(), sharers_.end());
}

std::span<const TriangleNeighbours::Sharer> TriangleNeighbours::sharers_of(uint32_t vertex) const {
    const auto begin = std::lower_bound(sharers_.begin(), sharers_.end(), Sharer{vertex, 0});
    auto end = begin;
    while (end != sharers_.end() && end->vertex == vertex) ++end;
    return {begin, end};
}

}  // namespace splat
