#include "mesh/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace mesh {

namespace {

constexpr size_t kLeaf = 4;          // primitives a leaf at most
constexpr size_t kParallel = 16384;  // below so many primitives a subtree is built by one thread
constexpr size_t kPiece = 16384;     // primitives handed to a thread at a time
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A tree over n primitives has this many leaves, of kLeaf primitives each but the last.
size_t leaf_count(size_t primitives) {
    return (primitives + kLeaf - 1) / kLeaf;
}

double squared_length(const glm::dvec3& v) {
    return glm::dot(v, v);
}

// From the zero vector to the segment from a to a + ab; a segment without length is a point.
double squared_to_segment(const glm::dvec3& a, const glm::dvec3& ab) {
    const double length = squared_length(ab);
    const double along = -glm::dot(a, ab);
    const double t = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0.0;
    return squared_length(a + t * ab);
}

// From the zero vector to the triangle (a, a + ab, a + ac).  The foot of the perpendicular counts only where
// its weights put it into the triangle, so that the answer is never too small; the sides cover all else.
double squared_to_triangle(const glm::dvec3& a, const glm::dvec3& ab, const glm::dvec3& ac) {
    const double sides =
        std::min({squared_to_segment(a, ab), squared_to_segment(a, ac), squared_to_segment(a + ab, ac - ab)});
    const glm::dvec3 normal = glm::cross(ab, ac);
    const double scale = squared_length(normal);
    if (!(scale > 0)) return sides;
    // The second step takes away what rounding leaves of the first: 1e-7 of a sliver of aspect 1e9.
    double v = 0, w = 0;
    glm::dvec3 rest = -a;
    for (int step = 0; step < 2; ++step) {
        v += glm::dot(glm::cross(rest, ac), normal) / scale;
        w += glm::dot(glm::cross(ab, rest), normal) / scale;
        rest = -(a + v * ab + w * ac);
    }
    if (!(v >= 0 && w >= 0 && v + w <= 1)) return sides;
    return std::min(sides, squared_length(rest));
}

double squared_to_box(const glm::dvec3& p, const glm::vec3& low, const glm::vec3& high) {
    return squared_length(glm::max(glm::max(glm::dvec3(low) - p, p - glm::dvec3(high)), 0.0));
}

std::vector<glm::vec3> gathered_corners(const Mesh& mesh) {
    if (mesh.is_cloud()) return mesh.positions;
    std::vector<glm::vec3> corners(3 * mesh.triangles.size());
    core::parallel_pieces(mesh.triangles.size(), kPiece, [&](size_t begin, size_t end) {
        for (size_t t = begin; t < end; ++t)
            for (int k = 0; k < 3; ++k) corners[3 * t + size_t(k)] = mesh.positions[mesh.triangles[t][k]];
    });
    return corners;
}

struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()}, high{-low};
    void add(const glm::vec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
};

}  // namespace

struct SurfaceDistance::Item {
    glm::vec3 middle;  // of the primitive's box
    uint32_t primitive;
};

SurfaceDistance::SurfaceDistance(const Mesh& mesh)
    : origin_(mesh.origin), corners_each_(mesh.is_cloud() ? 1 : 3) {
    const std::vector<glm::vec3> corners = gathered_corners(mesh);
    const size_t count = corners.size() / corners_each_;
    if (count == 0) return;
    std::vector<Item> items(count);
    core::parallel_pieces(count, kPiece, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Box box;
            for (size_t k = 0; k < corners_each_; ++k) box.add(corners[i * corners_each_ + k]);
            // Halved first: the sum of two floats may be too large for a float.
            items[i] = {0.5f * box.low + 0.5f * box.high, uint32_t(i)};
        }
    });
    nodes_.resize(2 * leaf_count(count) - 1);
    corners_.resize(corners.size());
    core::thread_arena().execute([&] { build(items, corners, 0, 0, count); });
}

// Nodes in depth-first order: a subtree over n primitives takes 2 * leaf_count(n) - 1 of them from `node`.
void SurfaceDistance::build(std::vector<Item>& items, const std::vector<glm::vec3>& corners, size_t node,
                            size_t begin, size_t end) {
    const size_t leaves = leaf_count(end - begin);
    if (leaves == 1) return build_leaf(items, corners, node, begin, end);
    Box middles;
    for (size_t i = begin; i < end; ++i) middles.add(items[i].middle);
    const glm::vec3 extent = 0.5f * middles.high - 0.5f * middles.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t split = begin + leaves / 2 * kLeaf;
    const auto at = [&](size_t i) { return items.begin() + ptrdiff_t(i); };
    std::nth_element(at(begin), at(split), at(end),
                     [axis](const Item& a, const Item& b) { return a.middle[axis] < b.middle[axis]; });

    const size_t left = node + 1, right = left + 2 * (leaves / 2) - 1;
    const auto build_left = [&] { build(items, corners, left, begin, split); };
    const auto build_right = [&] { build(items, corners, right, split, end); };
    if (end - begin < kParallel) {
        build_left();
        build_right();
    } else {
        core::parallel_for(2, [&](size_t side) { side == 0 ? build_left() : build_right(); });
    }
    nodes_[node] = {glm::min(nodes_[left].low, nodes_[right].low),
                    glm::max(nodes_[left].high, nodes_[right].high), uint32_t(right), 0};
}

void SurfaceDistance::build_leaf(const std::vector<Item>& items, const std::vector<glm::vec3>& corners,
                                 size_t node, size_t begin, size_t end) {
    Box box;
    for (size_t i = begin; i < end; ++i) {
        for (size_t k = 0; k < corners_each_; ++k) {
            const glm::vec3& corner = corners[items[i].primitive * corners_each_ + k];
            box.add(corner);
            corners_[i * corners_each_ + k] = corner;
        }
    }
    nodes_[node] = {box.low, box.high, uint32_t(begin), uint32_t(end - begin)};
}

double SurfaceDistance::squared_distance(const glm::dvec3& point, uint32_t primitive) const {
    const glm::vec3* c = &corners_[primitive * corners_each_];
    const glm::dvec3 a = glm::dvec3(c[0]) - point;
    if (corners_each_ == 1) return squared_length(a);
    return squared_to_triangle(a, glm::dvec3(c[1]) - glm::dvec3(c[0]), glm::dvec3(c[2]) - glm::dvec3(c[0]));
}

double SurfaceDistance::distance(const glm::dvec3& world_point, double limit) const {
    if (nodes_.empty()) return kInfinity;
    const glm::dvec3 point = world_point - origin_;
    struct Visit {
        double squared;
        uint32_t node;
    };
    Visit stack[64];  // one a level: the tree is balanced, so 32 levels hold 2^32 leaves
    int depth = 0;
    const auto visit = [&](uint32_t n) {
        return Visit{squared_to_box(point, nodes_[n].low, nodes_[n].high), n};
    };
    stack[depth++] = visit(0);
    double best = kInfinity;
    // Squared, of what is still looked at; with room for rounding, so that a distance found is a limit that
    // finds it.
    double bound = limit * limit * (1 + 1e-14);
    while (depth > 0) {
        const Visit here = stack[--depth];
        if (!(here.squared <= bound)) continue;
        const Node& node = nodes_[here.node];
        for (uint32_t i = 0; i < node.count; ++i) {
            best = std::min(best, squared_distance(point, node.right_or_first + i));
        }
        bound = std::min(bound, best);
        if (node.count > 0) continue;
        Visit near = visit(here.node + 1), far = visit(node.right_or_first);
        if (far.squared < near.squared) std::swap(near, far);
        stack[depth++] = far;
        stack[depth++] = near;
    }
    const double found = std::sqrt(best);
    return found <= limit ? found : kInfinity;
}

}  // namespace mesh
