#include "pm/build/details.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/parallel.h"

namespace pm {

namespace {

constexpr size_t kGrain = 1024;

// All of it first in the reverse order of the collapses, then in that of the file.
class Maker {
  public:
    Maker(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
          SimplifyResult&& simplified, bool is_open)
        : positions_(positions),
          is_open_(is_open),
          base_vertices_(uint32_t(simplified.base_vertices.size())) {
        number_vertices(simplified);
        link(simplified);
        set_faces(faces, simplified);
        set_needs();
        grow();
        raise_errors();
        cap_errors();
    }

    Details ordered() {
        const std::vector<uint32_t> order = order_by_error();
        std::vector<uint32_t> rank(order.size());
        for (uint32_t d = 0; d < order.size(); ++d) rank[order[d]] = d;
        const auto detail = [&](uint32_t d) { return d == kNone ? kNone : rank[d]; };
        const auto vertex = [&](uint32_t v) {
            return v == kNone || v < base_vertices_ ? v : base_vertices_ + rank[v - base_vertices_];
        };
        const auto corners = [&](const glm::u32vec3& c) {
            return glm::u32vec3(vertex(c.x), vertex(c.y), vertex(c.z));
        };
        Details out;
        out.base_vertices = base_vertices_;
        out.vertex.resize(vertex_.size());
        for (uint32_t v = 0; v < vertex_.size(); ++v) out.vertex[vertex(v)] = vertex_[v];
        for (const glm::u32vec3& face : base_faces_) out.base_faces.push_back(corners(face));
        for (const uint32_t d : order) {
            out.kept.push_back(vertex(kept_[d]));
            out.parent.push_back(detail(parent_[d]));
            out.needs.push_back(detail(needs_[d]));
            out.faces.push_back({corners(faces_[d].left), corners(faces_[d].right)});
            const Support& support = supports_[d];
            const bool has_cone = !is_open_ && support.cone.is_useful();
            out.cones.push_back(
                has_cone ? encode_cone(glm::dvec3(support.cone.axis), double(support.cone.half_angle))
                         : ConeCodes{});
            out.error.push_back(encode_error(support.error));
            out.radius.push_back(encode_radius(support.radius));
        }
        set_children(out);
        return out;
    }

  private:
    uint32_t count() const { return uint32_t(kept_.size()); }
    Hierarchy hierarchy() const { return {base_vertices_, base_faces_, kept_, parent_, needs_, faces_}; }

    void number_vertices(const SimplifyResult& s) {
        number_.resize(positions_.size());
        vertex_ = s.base_vertices;
        for (uint32_t v = 0; v < base_vertices_; ++v) number_[vertex_[v]] = v;
        for (auto c = s.collapses.rbegin(); c != s.collapses.rend(); ++c) {
            number_[c->removed] = uint32_t(vertex_.size());
            vertex_.push_back(c->removed);
        }
    }

    void link(const SimplifyResult& s) {
        std::vector<uint32_t> made_by(vertex_.size(), kNone);  // by vertex: the detail that made its node
        for (auto c = s.collapses.rbegin(); c != s.collapses.rend(); ++c) {
            const uint32_t d = count(), kept = number_[c->kept];
            kept_.push_back(kept);
            parent_.push_back(made_by[kept]);
            supports_.push_back(c->support);
            made_by[kept] = made_by[base_vertices_ + d] = d;
        }
    }

    void set_faces(std::span<const glm::u32vec3> faces, SimplifyResult& s) {
        const auto number = [&](uint32_t corner) { return number_[faces[corner / 3][int(corner % 3)]]; };
        const auto after = [](uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
        for (const uint32_t f : s.base_faces)
            base_faces_.emplace_back(number(3 * f), number(3 * f + 1), number(3 * f + 2));
        for (auto c = s.collapses.rbegin(); c != s.collapses.rend(); ++c) {
            SplitFaces made{glm::u32vec3(kNone), glm::u32vec3(kNone)};
            if (const uint32_t at = c->left_corner; at != kNone)
                made.left = {number(at), number(after(at)), number(after(after(at)))};
            if (const uint32_t at = c->right_corner; at != kNone)
                made.right = {number(after(after(at))), number(at), number(after(at))};
            faces_.push_back(made);
        }
        s = {};
        number_ = std::vector<uint32_t>();
    }

    void set_needs() {
        needs_.assign(count(), kNone);
        const Hierarchy tree = hierarchy();
        core::parallel_for(
            count(),
            [&](size_t i) {
                const auto d = uint32_t(i);
                const SplitFaces& faces = faces_[d];
                if (faces.left_cut() == kNone || faces.right_cut() == kNone) return;
                const uint32_t apart = split_apart(tree, faces.left_cut(), faces.right_cut());
                if (apart != kNone && !is_ancestor(tree, apart, d)) needs_[d] = apart;
            },
            kGrain);
    }

    const glm::dvec3& centre(uint32_t d) const { return positions_[vertex_[kept_[d]]]; }

    void grow_over(uint32_t d, uint32_t dependent) {
        Support& own = supports_[d];
        const Support& other = supports_[dependent];
        own.radius =
            std::max(own.radius, (glm::length(centre(d) - centre(dependent)) + other.radius) * (1 + 1e-12));
        own.error = std::max(own.error, other.error);
        own.cone = merged(own.cone, other.cone);
    }

    // From the last on, so that what a detail is grown over is grown itself.
    void grow() {
        const auto is_later = [](uint32_t a, uint32_t b) { return a != kNone && (b == kNone || a > b); };
        for (uint32_t d = count(); d-- > 0;) {
            if (needs_[d] == kNone) continue;
            uint32_t grown = needs_[d], above = d;
            while (grown != above) {
                if (is_later(above, grown)) {
                    above = parent_[above];
                } else {
                    grow_over(grown, d);
                    grown = parent_[grown];
                }
            }
        }
    }

    // What was charged for neighbours no other detail answers for: those that this one depends on are raised.
    void raise_errors() {
        for (uint32_t d = count(); d-- > 0;)
            for (const uint32_t on : {parent_[d], needs_[d]})
                if (on != kNone && supports_[d].neighbours_error > supports_[on].error)
                    supports_[on].error = supports_[on].neighbours_error = supports_[d].neighbours_error;
    }

    void cap_errors() {
        for (uint32_t d = 0; d < count(); ++d)
            for (const uint32_t on : {parent_[d], needs_[d]})
                if (on != kNone) supports_[d].error = std::min(supports_[d].error, supports_[on].error);
    }

    // Falling codes, each in the order of refinement.
    std::vector<uint32_t> order_by_error() const {
        std::vector<uint8_t> code(count());
        core::parallel_for(
            count(), [&](size_t d) { code[d] = encode_error(supports_[d].error); }, kGrain);
        std::array<uint32_t, 257> begin{};
        for (const uint8_t c : code) ++begin[size_t(256) - c];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        std::vector<uint32_t> order(count());
        for (uint32_t d = 0; d < count(); ++d) order[begin[size_t(255) - code[d]]++] = d;
        return order;
    }

    static void set_children(Details& out) {
        out.root_split.assign(out.base_vertices, kNone);
        out.children.assign(out.count(), {kNone, kNone});
        std::vector<uint32_t> depth(out.count());
        for (uint32_t d = 0; d < out.count(); ++d) {
            const uint32_t parent = out.parent[d];
            if (parent == kNone)
                out.root_split[out.kept[d]] = d;
            else if (out.kept[d] == out.kept[parent])
                out.children[parent].kept = d;
            else
                out.children[parent].fresh = d;
            depth[d] = parent == kNone ? 1 : depth[parent] + 1;
            out.depth = std::max(out.depth, depth[d]);
        }
    }

    std::span<const glm::dvec3> positions_;
    bool is_open_;
    uint32_t base_vertices_;
    std::vector<uint32_t> number_;  // by vertex as it was simplified
    std::vector<uint32_t> vertex_;  // by number
    std::vector<glm::u32vec3> base_faces_;
    std::vector<uint32_t> kept_, parent_, needs_;
    std::vector<SplitFaces> faces_;
    std::vector<Support> supports_;
};

}  // namespace

Details make_details(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
                     SimplifyResult&& simplified, bool is_open) {
    return Maker(positions, faces, std::move(simplified), is_open).ordered();
}

uint32_t split_apart(const Hierarchy& h, uint32_t a, uint32_t b) {
    // Up to the vertex that both come from.  There one of the two splits that led away from it is the earlier
    // one; or one of the leaves is that vertex's own.
    uint32_t vertex[2] = {a, b}, birth[2] = {kNone, kNone};
    while (vertex[0] != vertex[1]) {
        const int later = vertex[0] > vertex[1] ? 0 : 1;
        if (vertex[later] < h.base_vertices) return kNone;
        birth[later] = vertex[later] - h.base_vertices;
        vertex[later] = h.kept[birth[later]];
    }
    return std::min(birth[0], birth[1]);
}

bool is_ancestor(const Hierarchy& h, uint32_t detail, uint32_t below) {
    uint32_t d = h.parent[below];
    while (d != kNone && d > detail) d = h.parent[d];
    return d == detail;
}

}  // namespace pm
