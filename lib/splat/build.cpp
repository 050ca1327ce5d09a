#include "splat/build.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "core/error.h"
#include "core/pages.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "splat/build/cloud.h"
#include "splat/build/encode.h"
#include "splat/build/errors.h"
#include "splat/build/layout.h"
#include "splat/build/tree.h"
#include "splat/build/triangle_surface.h"
#include "splat/compress.h"
#include "splat/model.h"

namespace splat {

namespace {

constexpr uint32_t kHullLeaves = 49;        // leaves summarised by one box for the upper tree
constexpr double kOpenGap = 0.1;            // widest boundary, in radii, of a model still taken as closed
constexpr size_t kPiece = size_t(1) << 16;  // faces or leaves that a thread takes at a time
constexpr size_t kMostWatchers = 3;         // subtrees besides its own that see all the faces at a leaf

// Gives a vector's memory back (assigning {} would keep it).
template <class T>
void release(std::vector<T>& v) {
    std::vector<T>().swap(v);
}

struct Box {
    glm::vec3 low{std::numeric_limits<float>::max()}, high{std::numeric_limits<float>::lowest()};
    void extend(const Box& b) { low = glm::min(low, b.low), high = glm::max(high, b.high); }
};

// The faces that touch each subtree, and those at the corners of these, as leaf numbers, in the order of the
// input.
struct FaceBuckets {
    std::vector<glm::u32vec3> faces;
    std::vector<size_t> begin;  // by subtree, and the end
    std::span<const glm::u32vec3> of(size_t subtree) const {
        return std::span(faces).subspan(begin[subtree], begin[subtree + 1] - begin[subtree]);
    }
};

class Builder {
  public:
    Builder(mesh::Mesh&& mesh, const BuildOptions& options, BuildReport& report,
            const std::function<void(uint64_t)>& progress)
        : mesh_(std::move(mesh)), options_(options), report_(report), progress_(progress) {}

    void run(core::OutputFile& out) {
        choose_channels();
        if (mesh_.is_cloud()) {
            cloud_radii_ = mesh_.radii.empty() ? estimate_discs(mesh_) : std::move(mesh_.radii);
            report_.stage_ms.emplace_back("neighbours", watch_.lap_ms());
        }
        if (has_triangles()) {
            order_triangles();
            report_.stage_ms.emplace_back("order", watch_.lap_ms());
            neighbours_.emplace(triangles_, points_, subtree_begin_);
        } else {
            order_leaves();
            report_.stage_ms.emplace_back("order", watch_.lap_ms());
            place_model(Box{root_->low, root_->high}, points_.size(),
                        [&](size_t i) { return points_[i].position; });
            share_out_faces();
        }
        report_.stage_ms.emplace_back("faces", watch_.lap_ms());
        summarise_subtrees();
        encode_upper();
        encode_subtrees();
        set_upper_errors();
        judge_boundary();
        release(buckets_.faces);
        report_.stage_ms.emplace_back("encode", watch_.lap_ms());
        const TriangleSource source{triangles_, points_, report_.triangles};
        write_model(model_, has_triangles() ? &source : nullptr, report_.header, out);
        report_.stage_ms.emplace_back("write", watch_.lap_ms());
    }

  private:
    void choose_channels() {
        Header& h = report_.header;
        h.block_size = options_.block_size;
        h.vertices_in = mesh_.positions.size();
        h.triangles_in = mesh_.triangles.size();
        if (mesh_.is_cloud()) h.flags |= kCloud | kOpenSurface;
        if (mesh_.colours.empty()) {
            report_.left_out.emplace_back("colour: the input has none");
        } else if (!options_.keep_colour) {
            report_.left_out.emplace_back("colour: not wanted");
            release(mesh_.colours);
        } else if (std::all_of(mesh_.colours.begin(), mesh_.colours.end(),
                               [&](auto c) { return c == mesh_.colours[0]; })) {
            report_.left_out.emplace_back("colour: one for all, in the header");
            h.flags |= kConstantColour;
            h.colour = {mesh_.colours[0].r, mesh_.colours[0].g, mesh_.colours[0].b, 0};
            release(mesh_.colours);
        } else {
            h.flags |= kHasColour;
        }
        if (has_triangles())
            h.flags |= kTriangles;
        else if (!mesh_.is_cloud())
            report_.left_out.emplace_back("triangles: leaves are points");
    }

    bool has_triangles() const { return options_.leaf == Leaf::triangle; }

    // Which vertices a face uses; of a cloud, all.
    std::vector<uint8_t> find_used() const {
        std::vector<uint8_t> used(mesh_.positions.size(), mesh_.is_cloud());
        core::parallel_pieces(mesh_.triangles.size(), kPiece, [&](size_t begin, size_t end) {
            for (size_t f = begin; f < end; ++f)
                for (int k = 0; k < 3; ++k)
                    std::atomic_ref(used[mesh_.triangles[f][k]]).store(1, std::memory_order_relaxed);
        });
        return used;
    }

    // Leaves are the vertices that are used.
    void order_leaves() {
        const size_t n = mesh_.positions.size();
        const std::vector<uint8_t> used = find_used();
        core::reserve(points_, n);
        for (size_t v = 0; v < n; ++v)
            if (used[v]) points_.push_back({mesh_.positions[v], uint32_t(v)});
        if (points_.size() < n) report_.vertices_dropped["unreferenced"] = n - points_.size();
        if (points_.empty()) throw core::Error("no face is left, and the vertices belong to none");
        if (mesh_.normals.empty() && mesh_.colours.empty()) release(mesh_.positions);
        root_ = sort_into_tree(points_);
        core::resize(leaf_of_, n);
        core::parallel_pieces(points_.size(), kPiece, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) leaf_of_[points_[i].vertex] = uint32_t(i);
        });
        collect_subtrees(*root_);
    }

    // Leaves are the triangles.
    void order_triangles() {
        const std::vector<uint8_t> used = find_used();
        Box box;
        for (size_t v = 0; v < used.size(); ++v)
            if (used[v]) box.extend({mesh_.positions[v], mesh_.positions[v]});
        if (const auto unused = uint64_t(std::count(used.begin(), used.end(), 0)); unused > 0)
            report_.vertices_dropped["unreferenced"] = unused;
        const glm::vec3 anywhere = mesh_.positions[mesh_.triangles[0].x];
        place_model(box, used.size(), [&](size_t v) { return used[v] ? mesh_.positions[v] : anywhere; });
        triangles_ =
            make_triangle_leaves(mesh_, used, {model_offset_, inverse_scale_}, points_, report_.triangles);
        report_.header.lattice_bits = triangles_.lattice_bits;
        report_.zero_area_faces = report_.triangles.degenerate;
        root_ = sort_into_tree(points_);
        collect_subtrees(*root_);
    }

    void collect_subtrees(const UpperCut& cut) {
        if (cut.is_subtree()) {
            subtree_begin_.push_back(cut.begin);
            gap_sides_.push_back(cut.gap_sides);
            return;
        }
        collect_subtrees(*cut.left);
        collect_subtrees(*cut.right);
    }

    // The root's sphere about the middle of the box; model space makes it the unit sphere.  position(i): of
    // `count` points that it holds.
    template <class Position>
    void place_model(const Box& box, size_t count, const Position& position) {
        const glm::dvec3 low(box.low), high(box.high);
        // The origin is rounded in world coordinates, and what it is from there is exact: far from 0 the
        // model would else be shifted by the rounding.
        const glm::dvec3 origin = mesh_.origin + (0.5 * low + 0.5 * high);
        const glm::dvec3 middle = origin - mesh_.origin;
        const double size = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
        const double inverse = size > 0 ? 1 / size : 1;
        std::vector<double> squares((count + kPiece - 1) / kPiece, 0);
        core::parallel_pieces(count, kPiece, [&](size_t begin, size_t end) {
            double& square = squares[begin / kPiece];
            for (size_t i = begin; i < end; ++i) {
                const glm::dvec3 d = (glm::dvec3(position(i)) - middle) * inverse;
                square = std::max(square, glm::dot(d, d));
            }
        });
        double radius = std::sqrt(*std::max_element(squares.begin(), squares.end())) * (size > 0 ? size : 0);
        const double widest =
            cloud_radii_.empty() ? 0 : double(*std::max_element(cloud_radii_.begin(), cloud_radii_.end()));
        radius = (radius + 1.5 * widest) * 1.0001;
        // One point, or all equal: a sphere that is small against where it is.
        if (!(radius > 0)) {
            radius = std::max(1e-6 * glm::length(origin), 1e-30);
            for (float& r : cloud_radii_) r = float(0.5 * radius);
        }
        report_.header.origin = origin;
        report_.header.scale = radius;
        model_offset_ = -middle;
        inverse_scale_ = 1 / radius;
    }

    uint32_t subtree_of(uint32_t leaf) const {
        uint32_t s = subtree_hint_[leaf >> kHintShift];
        while (s + 1 < subtree_begin_.size() && subtree_begin_[s + 1] <= leaf) ++s;
        return s;
    }

    // Counting sort by piece of the input and subtree, so that the order is that of the input.
    void share_out_faces() {
        for (uint32_t leaf = 0, s = 0; leaf < points_.size(); leaf += 1u << kHintShift) {
            while (s + 1 < subtree_begin_.size() && subtree_begin_[s + 1] <= leaf) ++s;
            subtree_hint_.push_back(s);
        }
        const size_t subtrees = subtree_begin_.size();
        // Few pieces for many subtrees: the table of counts stays small beside the faces.
        const size_t piece = std::max(kPiece, mesh_.triangles.size() / 64 + 1);
        const size_t pieces = (mesh_.triangles.size() + piece - 1) / piece;
        core::parallel_for(pieces, [&](size_t p) {
            const size_t end = std::min(mesh_.triangles.size(), (p + 1) * piece);
            for (size_t f = p * piece; f < end; ++f)
                for (int k = 0; k < 3; ++k) mesh_.triangles[f][k] = leaf_of_[mesh_.triangles[f][k]];
        });
        release(leaf_of_);
        find_watchers(pieces, piece);
        std::vector<std::vector<uint32_t>> at(pieces);
        core::parallel_for(pieces, [&](size_t p) {
            at[p].assign(subtrees, 0);
            for_faces(p, piece, [&](uint32_t s, const glm::u32vec3&) { ++at[p][s]; });
        });
        buckets_.begin.assign(subtrees + 1, 0);
        std::vector<std::vector<size_t>> to(pieces, std::vector<size_t>(subtrees));
        size_t sum = 0;
        for (size_t s = 0; s < subtrees; ++s) {
            buckets_.begin[s] = sum;
            for (size_t p = 0; p < pieces; ++p) to[p][s] = sum, sum += at[p][s];
        }
        buckets_.begin[subtrees] = sum;
        core::resize(buckets_.faces, sum);
        core::parallel_for(pieces, [&](size_t p) {
            for_faces(p, piece,
                      [&](uint32_t s, const glm::u32vec3& face) { buckets_.faces[to[p][s]++] = face; });
        });
        release(mesh_.triangles);
        release(watchers_), release(is_watched_);
    }

    // A leaf, and a subtree that it does not belong to but has a face with.
    struct Watcher {
        uint32_t leaf, subtree;
        auto operator<=>(const Watcher&) const = default;
    };

    // Which leaves' faces other subtrees want to see.  Those of a leaf that has faces with many subtrees are
    // left out: in a soup of faces all would want to see all.
    void find_watchers(size_t pieces, size_t piece) {
        std::vector<std::vector<Watcher>> found(pieces);
        core::parallel_for(pieces, [&](size_t p) {
            const size_t end = std::min(mesh_.triangles.size(), (p + 1) * piece);
            for (size_t f = p * piece; f < end; ++f) {
                const glm::u32vec3& face = mesh_.triangles[f];
                const uint32_t s[3] = {subtree_of(face.x), subtree_of(face.y), subtree_of(face.z)};
                if (s[0] == s[1] && s[0] == s[2]) continue;
                for (int k = 0; k < 3; ++k)
                    for (int j = 0; j < 3; ++j)
                        if (s[j] != s[k]) found[p].push_back({face[k], s[j]});
            }
            std::sort(found[p].begin(), found[p].end());
            found[p].erase(std::unique(found[p].begin(), found[p].end()), found[p].end());
        });
        for (std::vector<Watcher>& w : found)
            watchers_.insert(watchers_.end(), w.begin(), w.end()), release(w);
        std::sort(watchers_.begin(), watchers_.end());
        watchers_.erase(std::unique(watchers_.begin(), watchers_.end()), watchers_.end());
        size_t kept = 0;
        for (size_t begin = 0, end = 0; begin < watchers_.size(); begin = end) {
            while (end < watchers_.size() && watchers_[end].leaf == watchers_[begin].leaf) ++end;
            if (end - begin > kMostWatchers) continue;
            for (size_t k = begin; k < end; ++k) watchers_[kept++] = watchers_[k];
        }
        watchers_.resize(kept);
        is_watched_.assign(points_.size(), false);
        for (const Watcher& w : watchers_) is_watched_[w.leaf] = true;
    }

    // Calls emit(subtree, face) once for each subtree that the face touches or that wants to see one of its
    // corners.
    template <class Emit>
    void for_faces(size_t p, size_t piece, const Emit& emit) {
        const size_t end = std::min(mesh_.triangles.size(), (p + 1) * piece);
        for (size_t f = p * piece; f < end; ++f) {
            const glm::u32vec3& face = mesh_.triangles[f];
            uint32_t sent[3 + 3 * kMostWatchers];
            size_t count = 0;
            const auto send = [&](uint32_t s) {
                if (std::find(sent, sent + count, s) != sent + count) return;
                sent[count++] = s;
                emit(s, face);
            };
            for (int k = 0; k < 3; ++k) send(subtree_of(face[k]));
            for (int k = 0; k < 3; ++k) {
                if (!is_watched_[face[k]]) continue;
                for (auto w = std::lower_bound(watchers_.begin(), watchers_.end(), Watcher{face[k], 0});
                     w != watchers_.end() && w->leaf == face[k]; ++w)
                    send(w->subtree);
            }
        }
    }

    glm::dvec3 model(const glm::vec3& position) const {
        return (glm::dvec3(position) + model_offset_) * inverse_scale_;
    }
    glm::dvec3 model(uint32_t leaf) const { return model(points_[leaf].position); }
    uint32_t subtree_end(size_t s) const {
        return s + 1 < subtree_begin_.size() ? subtree_begin_[s + 1] : uint32_t(points_.size());
    }

    // For the upper tree: boxes that hold the surface of some leaves each, sums of normals and colours.
    struct Summary {
        std::vector<glm::vec3> hull;  // corners of boxes, model space
        glm::dvec3 normal{0};
        glm::u64vec3 colour{0};
        uint64_t zero_area_faces = 0;  // whose first corner is a leaf of the subtree
    };

    void summarise_subtrees() {
        summary_.resize(subtree_begin_.size());
        core::parallel_for(
            summary_.size(), [&](size_t s) { summarise(s); }, 8);
        for (const Summary& sum : summary_) report_.zero_area_faces += sum.zero_area_faces;
    }

    void summarise(size_t s) {
        if (has_triangles()) return summarise_triangles(s);
        const uint32_t begin = subtree_begin_[s], end = subtree_end(s);
        const size_t boxes = (end - begin + kHullLeaves - 1) / kHullLeaves;
        std::vector<Box> box(boxes);
        Summary& sum = summary_[s];
        for (uint32_t leaf = begin; leaf < end; ++leaf) {
            const uint32_t vertex = points_[leaf].vertex;
            const glm::vec3& at = points_[leaf].position;
            // Clouds: a radius on all sides, and what the rounding of the sum may take away.
            const glm::vec3 r =
                cloud_radii_.empty() ? glm::vec3(0) : 1.1f * cloud_radii_[vertex] + 1e-6f * glm::abs(at);
            box[(leaf - begin) / kHullLeaves].extend({at - r, at + r});
            if (!mesh_.colours.empty()) sum.colour += glm::u64vec3(mesh_.colours[vertex]);
            if (mesh_.is_cloud() && !mesh_.normals.empty()) sum.normal += glm::dvec3(mesh_.normals[vertex]);
        }
        for (const glm::u32vec3& face : buckets_.of(s)) {
            const bool is_own[3] = {face.x - begin < end - begin, face.y - begin < end - begin,
                                    face.z - begin < end - begin};
            if (!is_own[0] && !is_own[1] && !is_own[2]) continue;
            const glm::vec3 &a = points_[face.x].position, &p = points_[face.y].position,
                            &q = points_[face.z].position;
            const Box all{glm::min(a, glm::min(p, q)), glm::max(a, glm::max(p, q))};
            for (int k = 0; k < 3; ++k)
                if (is_own[k]) box[(face[k] - begin) / kHullLeaves].extend(all);
            const glm::dvec3 to_p = glm::dvec3(p) - glm::dvec3(a), to_q = glm::dvec3(q) - glm::dvec3(a),
                             n = glm::cross(to_p, to_q);
            sum.normal += n;
            if (is_own[0])
                sum.zero_area_faces +=
                    !(glm::dot(n, n) > 1e-24 * glm::dot(to_p, to_p) * glm::dot(to_q, to_q));
        }
        sum.normal *= mesh_.is_cloud() ? 1 : inverse_scale_ * inverse_scale_;
        for (const Box& b : box)
            for (int k = 0; k < 8; ++k)
                sum.hull.emplace_back(model(glm::vec3(k & 1 ? b.high.x : b.low.x, k & 2 ? b.high.y : b.low.y,
                                                      k & 4 ? b.high.z : b.low.z)));
    }

    void summarise_triangles(size_t s) {
        const uint32_t begin = subtree_begin_[s], end = subtree_end(s);
        Summary& sum = summary_[s];
        for (uint32_t first = begin; first < end; first += kHullLeaves) {
            Box box;
            for (uint32_t leaf = first; leaf < std::min(end, first + kHullLeaves); ++leaf) {
                const glm::u32vec3 t = triangles_.triangles[points_[leaf].vertex];
                glm::u64vec3 colour(0);
                for (int k = 0; k < 3; ++k) {
                    const auto at = glm::vec3(triangles_.at(t[k]));
                    box.extend({at, at});
                    if (!mesh_.colours.empty()) colour += glm::u64vec3(mesh_.colours[t[k]]);
                }
                sum.colour += colour / uint64_t(3);
                sum.normal += glm::cross(triangles_.at(t.y) - triangles_.at(t.x),
                                         triangles_.at(t.z) - triangles_.at(t.x));
            }
            for (int k = 0; k < 8; ++k)
                sum.hull.emplace_back(k & 1 ? box.high.x : box.low.x, k & 2 ? box.high.y : box.low.y,
                                      k & 4 ? box.high.z : box.low.z);
        }
    }

    // A child of an upper node: a cut, opened as long as there is room, the widest first.
    struct UpperItem {
        const UpperCut* cut;
        bool is_between;
    };

    static std::vector<const UpperCut*> open_cuts(const UpperCut& cut) {
        std::vector<const UpperCut*> open{&cut};
        while (open.size() < size_t(kMaxFanOut)) {
            size_t widest = open.size();
            double width = -1;
            for (size_t k = 0; k < open.size(); ++k) {
                const double w = glm::length(glm::dvec3(open[k]->high) - glm::dvec3(open[k]->low));
                if (!open[k]->is_subtree() && w > width) widest = k, width = w;
            }
            if (widest == open.size()) break;
            const UpperCut* const c = open[widest];
            open[widest] = c->left.get();
            open.insert(open.begin() + ptrdiff_t(widest) + 1, c->right.get());
        }
        return open;
    }

    // Subtrees [first, last) of a cut.
    std::pair<size_t, size_t> subtrees_of(const UpperCut& cut) const {
        const auto at = [&](uint32_t leaf) {
            return size_t(std::lower_bound(subtree_begin_.begin(), subtree_begin_.end(), leaf) -
                          subtree_begin_.begin());
        };
        return {at(cut.begin), at(cut.end)};
    }

    void encode_upper() {
        hull_begin_.assign(1, 0);
        for (const Summary& s : summary_) {
            hull_.insert(hull_.end(), s.hull.begin(), s.hull.end());
            hull_begin_.push_back(hull_.size());
        }
        root_node_.normal = glm::vec3(0, 0, 1);
        glm::dvec3 normal(0);
        glm::u64vec3 colour(0);
        for (const Summary& s : summary_) normal += s.normal, colour += s.colour;
        if (const double length = glm::length(normal); length > 0)
            root_node_.normal = glm::vec3(normal / length);
        report_.header.root_normal = root_node_.normal;
        if (report_.header.has_colour()) {
            const glm::u64vec3 mean = colour / uint64_t(points_.size());
            report_.header.colour = {uint8_t(mean.r), uint8_t(mean.g), uint8_t(mean.b), 0};
        }
        model_.subtrees.resize(subtree_begin_.size());
        subtree_parent_.resize(subtree_begin_.size());
        std::vector<UpperItem> items;  // by node
        std::vector<UpperItem> top;
        for (const UpperCut* c : open_cuts(*root_)) top.push_back({c, false});
        add_upper_group(top, root_node_, items);
        for (size_t node = 0; node < items.size(); ++node) {
            const UpperItem item = items[node];
            if (item.cut->is_subtree()) continue;
            std::vector<UpperItem> children;
            if (item.is_between)
                children.push_back({item.cut, false});
            else
                for (const UpperCut* c : open_cuts(*item.cut)) children.push_back({c, false});
            model_.upper.child_group[node] = int32_t(model_.upper.groups.size());
            model_.upper.attitude[node] = uint16_t(model_.upper.attitude[node] | children.size());
            const Node decoded = model_.upper.decoded[node];
            add_upper_group(children, decoded, items);
        }
    }

    // Codes the children as a group; appends them to `items`.  A subtree's root is coded with its subtree:
    // here it only gets its place and its parent.
    void add_upper_group(std::vector<UpperItem>& children, const Node& parent,
                         std::vector<UpperItem>& items) {
        CodedTree& upper = model_.upper;
        GroupContent content;
        Lanes<glm::u8vec3> colour;
        for (const UpperItem& item : children)
            if (!item.cut->is_subtree()) add_content(*item.cut, parent, content, colour[content.count]);
        GroupFit fit;
        if (content.count > 0) fit_group(content, parent, fit);
        upper.groups.push_back({uint32_t(upper.size()), uint32_t(children.size())});
        size_t lane = 0;
        for (UpperItem& item : children) {
            if (item.cut->is_subtree()) {
                const size_t subtree = subtrees_of(*item.cut).first;
                upper.add({}, 0, {}, parent);
                upper.child_group.back() = -2 - int32_t(subtree);
                subtree_parent_[subtree] = parent;
            } else {
                report_.fit.count(fit, lane, false);
                item.is_between = fit.is_between[lane];
                upper.add(fit, lane, colour[lane], parent);
                ++lane;
            }
            items.push_back(item);
        }
    }

    // Adds a cut to what is to be coded as a group.
    void add_content(const UpperCut& cut, const Node& parent, GroupContent& content, glm::u8vec3& colour) {
        const auto [first, last] = subtrees_of(cut);
        glm::dvec3 normal(0);
        glm::u64vec3 sum(0);
        for (size_t s = first; s < last; ++s) normal += summary_[s].normal, sum += summary_[s].colour;
        colour = glm::u8vec3(sum / uint64_t(cut.size()));
        const size_t k = content.count++, begin = hull_begin_[first], end = hull_begin_[last];
        content.normal[k] = unit_or(normal, parent.normal);
        content.is_leaf[k] = false;
        content.points[k] = end - begin;
        const size_t rows = content.rows;
        content.set_rows(std::max(rows, end - begin));
        const auto centre = glm::vec3(parent.centre);
        for (size_t row = 0; row < content.rows; ++row)
            content.set_point(row, k, hull_[begin + std::min(row, end - begin - 1)] - centre);
        for (size_t other = 0; other < k; ++other)
            for (size_t row = rows; row < content.rows; ++row)
                content.set_point(row, other, {content.x[other], content.y[other], content.z[other]});
    }

    void encode_subtrees() {
        std::vector<FitCounts> counts(model_.subtrees.size());
        boundary_.resize(model_.subtrees.size());
        std::atomic<uint64_t> leaves_done = 0;
        core::parallel_for(model_.subtrees.size(), [&](size_t s) {
            encode_subtree_at(s, counts[s]);
            const uint64_t leaves = subtree_end(s) - subtree_begin_[s];
            if (progress_) progress_(leaves_done += leaves);
        });
        for (const FitCounts& c : counts) report_.fit.add(c);
    }

    void encode_subtree_at(size_t s, FitCounts& counts) {
        if (has_triangles()) {
            const TriangleSubtree in{s,       subtree_begin_[s], subtree_end(s),
                                     points_, &*neighbours_,     mesh_.colours};
            core::ProcessorWatch watch;
            Surface surface = gather_triangles(in, triangles_, boundary_[s], counts.open_fans);
            counts.ms.surface = watch.lap_ms();
            model_.subtrees[s] = encode_triangles(std::move(surface), gap_sides_[s], !mesh_.colours.empty(),
                                                  subtree_parent_[s], counts);
            return;
        }
        SubtreeInput in;
        in.begin = subtree_begin_[s], in.end = subtree_end(s);
        in.points = points_;
        in.faces = buckets_.of(s);
        in.offset = model_offset_, in.inverse_scale = inverse_scale_;
        in.normals = mesh_.normals, in.colours = mesh_.colours, in.cloud_radii = cloud_radii_;
        model_.subtrees[s] = encode_subtree(in, gap_sides_[s], subtree_parent_[s], counts, boundary_[s]);
    }

    void set_upper_errors() {
        CodedTree& upper = model_.upper;
        for (size_t node = upper.size(); node-- > 0;) {
            const int32_t group = upper.child_group[node];
            if (group <= -2) {
                upper.decoded[node] = model_.subtrees[size_t(-2 - group)].decoded[0];
            } else {
                set_error(upper, node, error_over_group(upper.decoded[node], size_t(group)));
            }
        }
        report_.header.root_error = std::min(2.0f, error_over_group(root_node_, 0));
    }

    float error_over_group(const Node& node, size_t group) const {
        const auto [first, count] = model_.upper.groups[group];
        const Node* parts[kMaxFanOut];
        for (uint32_t k = 0; k < count; ++k) parts[k] = &model_.upper.decoded[first + k];
        return error_over(node, {parts, count});
    }

    // A model whose boundaries are all small (scan holes) is culled like a closed one.
    void judge_boundary() {
        std::unordered_map<uint32_t, uint32_t> parent;
        const auto find = [&](uint32_t v) {
            auto it = parent.try_emplace(v, v).first;
            while (it->second != it->first) {
                auto up = parent.find(it->second);
                it->second = up->second;
                it = up;
            }
            return it->first;
        };
        for (const auto& edges : boundary_)
            for (const glm::u32vec2& e : edges) {
                ++report_.boundary_edges;
                const uint32_t a = find(e.x), b = find(e.y);
                parent[std::max(a, b)] = std::min(a, b);
            }
        std::unordered_map<uint32_t, std::pair<glm::dvec3, glm::dvec3>> boxes;
        for (const auto& edges : boundary_)
            for (const glm::u32vec2& e : edges)
                for (const uint32_t v : {e.x, e.y}) {
                    const glm::dvec3 at = has_triangles() ? triangles_.at(v) : model(v);
                    auto [it, fresh] = boxes.try_emplace(find(v), at, at);
                    it->second.first = glm::min(it->second.first, at);
                    it->second.second = glm::max(it->second.second, at);
                }
        for (const auto& [v, box] : boxes)
            report_.widest_gap = std::max(report_.widest_gap, glm::length(box.second - box.first));
        report_.boundary_edges /= 2;  // each was noted at both ends
        if (report_.widest_gap > kOpenGap) report_.header.flags |= kOpenSurface;
    }

    static constexpr int kHintShift = 8;

    mesh::Mesh mesh_;
    const BuildOptions& options_;
    BuildReport& report_;
    const std::function<void(uint64_t)>& progress_;
    core::Stopwatch watch_;
    std::vector<float> cloud_radii_;
    std::vector<TreePoint> points_;
    std::vector<uint32_t> leaf_of_;
    std::unique_ptr<UpperCut> root_;
    std::vector<uint32_t> subtree_begin_, subtree_hint_;
    std::vector<std::span<const GapSide>> gap_sides_;  // by subtree
    glm::dvec3 model_offset_{0};
    double inverse_scale_ = 1;
    TriangleLeaves triangles_;
    std::optional<TriangleNeighbours> neighbours_;
    FaceBuckets buckets_;
    std::vector<Watcher> watchers_;  // by leaf
    std::vector<bool> is_watched_;   // by leaf
    std::vector<Summary> summary_;
    std::vector<glm::vec3> hull_;
    std::vector<size_t> hull_begin_;
    Node root_node_;
    CodedModel model_;
    std::vector<Node> subtree_parent_;
    std::vector<std::vector<glm::u32vec2>> boundary_;
};

}  // namespace

uint64_t memory_to_build(uint64_t vertices, uint64_t triangles, Leaf leaf, bool has_colour,
                         bool has_normals) {
    // Meshes: tree points and leaf numbers, faces twice (input and buckets).  Clouds: positions, tree points
    // and their spare, the tree of neighbours.  Measured beside it: scripts/bench, "build memory".
    const uint64_t attributes =
        (has_colour ? 3 : 0) + (has_normals ? 24 : 0) + (has_colour || has_normals ? 12 : 0);
    const uint64_t per_vertex = attributes + (triangles > 0 ? 24 : 120);
    if (leaf == Leaf::triangle) return (uint64_t(48) << 20) + vertices * (attributes + 30) + triangles * 60;
    return (uint64_t(48) << 20) + vertices * per_vertex + triangles * 26;
}

constexpr double kLargestScale =
    3e37;  // sums of some coordinates of this size are finite in single precision

BuildReport build(mesh::Mesh&& mesh, const BuildOptions& options, core::OutputFile& out,
                  const std::string& name, const std::function<void(uint64_t)>& progress) {
    BuildReport report;
    if (mesh.positions.empty()) throw core::Error(name + ": has no vertices, so there is nothing to build");
    if (options.leaf == Leaf::triangle && mesh.is_cloud())
        throw core::Error(name + ": has no triangles to be leaves; bare points are built with --leaf point");
    report.memory_needed = memory_to_build(mesh.positions.size(), mesh.triangles.size(), options.leaf,
                                           !mesh.colours.empty(), !mesh.normals.empty());
    if (options.memory_limit > 0 && report.memory_needed > options.memory_limit)
        throw core::Error(core::text(
            "%s: needs about %llu MiB for %zu vertices and %zu triangles, --memory allows %llu MiB",
            name.c_str(), static_cast<unsigned long long>((report.memory_needed >> 20) + 1),
            mesh.positions.size(), mesh.triangles.size(),
            static_cast<unsigned long long>(options.memory_limit >> 20)));
    if (options.compress) {
        // Symbols are counted before the first block can be written, so the plain model is kept: less than
        // the faces that were just released.
        core::OutputFile plain(core::OutputFile::InMemory{out.name()});
        Builder(std::move(mesh), options, report, progress).run(plain);
        core::Stopwatch watch;
        const Model model(plain.read_back());
        const CompressedSizes sizes = write_compressed(plain_of(model), out);
        report.file_bytes = sizes.file_bytes;
        report.channels = channels_of(report.header, sizes);
        report.stage_ms.emplace_back("compress", watch.lap_ms());
    } else {
        Builder(std::move(mesh), options, report, progress).run(out);
        report.file_bytes = report.header.plain_bytes();
        report.channels = channels_of(report.header, report.file_bytes);
    }
    if (report.header.scale > kLargestScale)
        throw core::Error(
            core::text("%s: its radius is %g; beyond %g sums of coordinates leave single precision: scale it",
                       name.c_str(), report.header.scale, kLargestScale));
    return report;
}

}  // namespace splat
