#include "splat/build/triangle_surface.h"

#include <algorithm>
#include <cmath>

#include "splat/corner_normal.h"

namespace splat {

namespace {

// A triangle whose normal is further off that of one of its corners is at a crease: cos(40 degrees), below
// the 45 that a cube's edges have.  Where the faces about the corner go one way but for a few small ones it
// is none, but noise: the sum of their normals has a length of more than 0.9 of their areas.
constexpr double kCreaseCosine = 0.76604444311897804, kNoise = 0.9;

uint64_t mix(uint64_t x) {
    x = (x + 1) * 0x9e3779b97f4a7c15u;
    return x ^ x >> 29;
}

class TriangleGatherer {
  public:
    TriangleGatherer(const TriangleSubtree& input, TriangleLeaves& leaves) : in_(input), leaves_(leaves) {
        out_.count = in_.end - in_.begin;
        out_.triangles.rounding = float(0.87 * leaves_.step);  // sqrt(3) / 2
    }

    Surface run(std::vector<glm::u32vec2>& boundary, uint64_t& open_fans) {
        number_vertices();
        measure_faces();
        gather_fans();
        gather_leaves();
        for (uint32_t v = 0; v < own_vertices_; ++v) finish_vertex(v, boundary, open_fans);
        return std::move(out_);
    }

  private:
    TriangleFans& fans() { return out_.triangles; }
    const TriangleFans& fans() const { return out_.triangles; }

    // Vertices of the leaves come first, then those that only triangles of others have.
    void number_vertices() {
        const std::span<const uint32_t> strangers = in_.neighbours->of(in_.number);
        faces_.reserve(out_.count + strangers.size());
        for (uint32_t i = in_.begin; i < in_.end; ++i) number_corners(in_.points[i].vertex);
        own_vertices_ = uint32_t(vertices_.size());
        for (const uint32_t t : strangers) number_corners(t);
        base_ = leaves_.corners[vertices_[0]];
        out_.base = leaves_.at(vertices_[0]);
        fans().at.reserve(vertices_.size());
        for (const uint32_t v : vertices_)
            fans().at.push_back(between(base_, leaves_.corners[v]) * leaves_.step);
        fans().corners.assign(faces_.begin(), faces_.begin() + out_.count);
    }
    void number_corners(uint32_t triangle) {
        const glm::u32vec3 t = leaves_.triangles[triangle];
        faces_.emplace_back(number_of(t.x), number_of(t.y), number_of(t.z));
    }
    uint32_t number_of(uint32_t vertex) {
        if (2 * vertices_.size() >= numbers_.size()) rehash(std::max<size_t>(1024, 2 * numbers_.size()));
        size_t slot = mix(vertex) >> 32 & (numbers_.size() - 1);
        while (numbers_[slot] != 0 && vertices_[numbers_[slot] - 1] != vertex)
            slot = (slot + 1) & (numbers_.size() - 1);
        if (numbers_[slot] == 0) {
            vertices_.push_back(vertex);
            numbers_[slot] = uint32_t(vertices_.size());
        }
        return numbers_[slot] - 1;
    }
    void rehash(size_t size) {
        numbers_.assign(size, 0);
        for (size_t n = 0; n < vertices_.size(); ++n) {
            size_t slot = mix(vertices_[n]) >> 32 & (size - 1);
            while (numbers_[slot] != 0) slot = (slot + 1) & (size - 1);
            numbers_[slot] = uint32_t(n) + 1;
        }
    }

    static glm::dvec3 between(const glm::ivec3& from, const glm::ivec3& to) {
        return glm::dvec3(to) - glm::dvec3(from);
    }
    glm::dvec3 edge(uint32_t from, uint32_t to) const {
        return between(leaves_.corners[vertices_[from]], leaves_.corners[vertices_[to]]);
    }

    // In lattice steps: products of edges are integers, and where edges are shorter than 2^25 steps their
    // sums are exact, whatever their order.
    void measure_faces() {
        normal_.reserve(faces_.size());
        vertex_normal_.assign(own_vertices_, glm::dvec3(0)), vertex_area_.assign(own_vertices_, 0);
        for (const glm::u32vec3& f : faces_) {
            normal_.push_back(glm::cross(edge(f.x, f.y), edge(f.x, f.z)));
            const double area = glm::length(normal_.back());
            for (int k = 0; k < 3; ++k)
                if (f[k] < own_vertices_) vertex_normal_[f[k]] += normal_.back(), vertex_area_[f[k]] += area;
        }
    }

    void gather_fans() {
        TriangleFans& out = fans();
        out.begin.assign(own_vertices_ + 1, 0);
        for (const glm::u32vec3& f : faces_)
            for (int k = 0; k < 3; ++k)
                if (f[k] < own_vertices_) ++out.begin[f[k] + 1];
        for (uint32_t v = 0; v < own_vertices_; ++v) out.begin[v + 1] += out.begin[v];
        out.fan.resize(out.begin.back() + kSpare), out.p.resize(out.fan.size()), out.q.resize(out.fan.size());
        std::vector<uint32_t> to(out.begin.begin(), out.begin.end() - 1);
        std::vector<uint64_t> clash(own_vertices_,
                                    0);  // sums of hashes: 0 where each edge is left as often as entered
        for (const glm::u32vec3& f : faces_)
            for (int k = 0; k < 3; ++k) {
                if (f[k] >= own_vertices_) continue;
                const uint32_t p = f[(k + 1) % 3], q = f[(k + 2) % 3], at = to[f[k]]++;
                out.fan[at] = {p, q};
                out.p.set(at, glm::vec3(edge(f[k], p) * leaves_.step)),
                    out.q.set(at, glm::vec3(edge(f[k], q) * leaves_.step));
                clash[f[k]] += mix(p) - mix(q);
            }
        out.is_closed.reserve(own_vertices_);
        for (const uint64_t c : clash) out.is_closed.push_back(c == 0);
    }

    void gather_leaves() {
        const size_t room = out_.count + kSpare;
        out_.corners.resize(3 * size_t(out_.count) + kSpare), out_.face_normals.resize(room);
        out_.corner_begin.assign(1, 0), out_.normal_begin.assign(1, 0);
        out_.colour_sum.assign(1, glm::u64vec3(0));
        out_.is_closed.assign(out_.count, 1);  // fans of vertices are told of by finish_vertex()
        for (uint32_t i = 0; i < out_.count; ++i) {
            const glm::u32vec3 f = faces_[i];
            out_.at.push_back(fans().at[f.x]);
            out_.leaf.push_back(in_.begin + i);
            uint32_t front = 3 * i, back = front + 3;  // corners that siblings before have stand last
            for (int k = 0; k < 3; ++k)
                out_.corners.set(is_of_sibling_before(i, f[k]) ? --back : front++,
                                 glm::vec3(edge(f.x, f[k]) * leaves_.step));
            out_.rim_end.push_back(back);
            out_.corner_begin.push_back(3 * (i + 1));
            uint32_t normals = out_.normal_begin.back();
            const glm::dvec3 n = normal_[i];
            if (const double length = glm::length(n); length > 0)
                out_.face_normals.set(normals++, glm::vec3(n / length));
            out_.normal_begin.push_back(normals);
            leaves_.is_smooth[in_.points[in_.begin + i].vertex] = is_smooth(i);
            // The triangle's own.  With the mean of its corners' normals, by which the mesh is shaded, splats
            // of triangles were 0.9 dB better (armadillo, 640 x 360), but thicker: silhouettes grew by a
            // sixth more, and where splats are between triangles it was 0.8 dB worse (dragon, 4x zoom).
            out_.normal.push_back(n * (leaves_.step * leaves_.step));
            out_.colour_sum.push_back(out_.colour_sum.back() + glm::u64vec3(colour_of(f)));
        }
    }

    bool is_of_sibling_before(uint32_t leaf, uint32_t vertex) const {
        for (uint32_t i = Surface::first_sibling(leaf); i < leaf; ++i)
            if (faces_[i].x == vertex || faces_[i].y == vertex || faces_[i].z == vertex) return true;
        return false;
    }

    bool is_smooth(uint32_t i) const {
        const double area = glm::length(normal_[i]);
        if (!(area > 0)) return false;
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = faces_[i][k];
            if (leaves_.normals_are_given) {
                if (leaves_.normals[vertices_[v]] == 0) return false;
                continue;
            }
            const glm::dvec3& sum = vertex_normal_[v];
            const double length = glm::length(sum);
            if (!(length > 0)) return false;
            if (length > kNoise * vertex_area_[v]) continue;
            if (glm::dot(sum, normal_[i]) < kCreaseCosine * area * length) return false;
        }
        return true;
    }

    glm::u8vec3 colour_of(const glm::u32vec3& face) const {
        if (in_.colours.empty()) return glm::u8vec3(0);
        glm::uvec3 sum(1);
        for (int k = 0; k < 3; ++k) sum += glm::uvec3(in_.colours[vertices_[face[k]]]);
        return glm::u8vec3(sum / 3u);
    }

    // What only the vertex's owner, who knows all faces about it, can tell.
    void finish_vertex(uint32_t v, std::vector<glm::u32vec2>& boundary, uint64_t& open_fans) {
        if (!in_.neighbours->is_owned(vertices_[v], in_.number)) return;
        if (!leaves_.normals_are_given) {
            const double length = glm::length(vertex_normal_[v]);
            leaves_.normals[vertices_[v]] = length > 0 ? encode_corner_normal(vertex_normal_[v] / length) : 0;
        }
        if (fans().is_closed[v]) return;
        ++open_fans;
        note_boundary(v, boundary);
    }

    // The edges at vertex v that have no partner.
    void note_boundary(uint32_t v, std::vector<glm::u32vec2>& boundary) {
        std::vector<uint32_t> left, entered;
        for (uint32_t k = fans().begin[v]; k < fans().begin[v + 1]; ++k)
            left.push_back(fans().fan[k].x), entered.push_back(fans().fan[k].y);
        std::sort(left.begin(), left.end()), std::sort(entered.begin(), entered.end());
        const auto note_lone = [&](const std::vector<uint32_t>& ends, const std::vector<uint32_t>& partners) {
            for (const uint32_t end_of_edge : ends)
                if (!std::binary_search(partners.begin(), partners.end(), end_of_edge))
                    boundary.emplace_back(vertices_[v], vertices_[end_of_edge]);
        };
        note_lone(left, entered), note_lone(entered, left);
    }

    const TriangleSubtree& in_;
    TriangleLeaves& leaves_;
    Surface out_;
    std::vector<uint32_t> vertices_;  // of the input, by number
    std::vector<uint32_t> numbers_;   // by hash: number + 1, 0: none
    uint32_t own_vertices_ = 0;
    std::vector<glm::u32vec3> faces_;                 // vertices' numbers; the leaves come first
    std::vector<glm::dvec3> normal_, vertex_normal_;  // lattice steps, squared
    std::vector<double> vertex_area_;
    glm::ivec3 base_{0};
};

}  // namespace

Surface gather_triangles(const TriangleSubtree& input, TriangleLeaves& leaves,
                         std::vector<glm::u32vec2>& boundary, uint64_t& open_fans) {
    return TriangleGatherer(input, leaves).run(boundary, open_fans);
}

}  // namespace splat
