#include "splat/build/encode.h"

#include <algorithm>
#include <span>
#include <tuple>

#include "core/stopwatch.h"
#include "splat/build/errors.h"

namespace splat {

void CodedTree::add(const GroupFit& fit, size_t k, glm::u8vec3 mean, const Node& parent) {
    attitude.push_back(fit.attitude[k]);
    place.push_back(fit.place[k]);
    shape.push_back(fit.shape[k]);
    colour.push_back(encode_colour(mean));
    child_group.push_back(kLeaf);
    decoded.push_back(node_of(fit, k, colour.back(), parent));
}

void CodedTree::reserve(size_t nodes) {
    for (auto* codes : {&attitude, &place, &colour}) codes->reserve(nodes);
    shape.reserve(nodes), child_group.reserve(nodes), decoded.reserve(nodes);
}

void FitCounts::add(const FitCounts& o) {
    inserted += o.inserted, leaves += o.leaves, inner += o.inner;
    leaf_inflation += o.leaf_inflation, inner_inflation += o.inner_inflation;
    worst_leaf_inflation = std::max(worst_leaf_inflation, o.worst_leaf_inflation);
    open_fans += o.open_fans;
    ms.add(o.ms);
}

void FitCounts::count(const GroupFit& fit, size_t k, bool is_leaf) {
    if (fit.is_between[k]) {
        ++inserted;
    } else if (is_leaf) {
        ++leaves;
        leaf_inflation += double(fit.inflation[k]);
        worst_leaf_inflation = std::max(worst_leaf_inflation, fit.inflation[k]);
    } else {
        ++inner;
        inner_inflation += double(fit.inflation[k]);
    }
}

namespace {

// A run of leaves that is to become a node.
struct Run {
    uint32_t begin, end;
    uint32_t size() const { return end - begin; }
};

// Prisms that each hold what some leaves in a row must cover, 16 corners each, relative to the first of these
// leaves.
struct Hulls {
    static constexpr uint32_t kCorners = 16;
    uint32_t leaves;  // of each
    PointArrays corners;
};

class SubtreeEncoder {
  public:
    SubtreeEncoder(Surface&& surface, std::span<const GapSide> gap_sides, bool has_colour, FitCounts& counts)
        : counts_(counts), gap_sides_(gap_sides), has_colour_(has_colour), surface_(std::move(surface)) {}

    CodedTree run(const Node& parent, std::vector<glm::u32vec2>& boundary) {
        core::ProcessorWatch watch;
        make_hulls();
        encode_nodes(parent);
        leaf_of_.reserve(runs_.size());
        for (const Run& run : runs_) leaf_of_.push_back(run.begin);
        counts_.ms.fit = watch.lap_ms();
        counts_.ms.leaf_errors = set_errors(tree_, surface_, leaf_of_);
        counts_.ms.inner_errors = watch.lap_ms() - counts_.ms.leaf_errors;
        for (uint32_t i = 0; i < surface_.count; ++i)
            if (!surface_.is_closed[i] && surface_.valence(i) > 0) note_boundary(i, boundary);
        if (surface_.has_triangles()) {
            tree_.leaf = std::move(leaf_of_);
            for (uint32_t& leaf : tree_.leaf) leaf = surface_.leaf[leaf];
        }
        // What stays until the file is written is kept small.
        tree_.decoded = std::vector<Node>{tree_.decoded[0]};
        for (auto* codes : {&tree_.attitude, &tree_.place, &tree_.colour}) codes->shrink_to_fit();
        tree_.shape.shrink_to_fit(), tree_.child_group.shrink_to_fit(), tree_.groups.shrink_to_fit();
        if (!has_colour_) std::vector<uint16_t>().swap(tree_.colour);
        return std::move(tree_);
    }

  private:
    // Weighted by area.  Not by differences of running sums: beside faces of a landscape those of a pebble
    // are lost in their rounding.
    glm::dvec3 normal_of(const Run& run) const {
        glm::dvec3 sum(0);
        for (uint32_t i = run.begin; i < run.end; ++i) sum += surface_.normal[i];
        return sum;
    }

    glm::u8vec3 colour_of(const Run& run) const {
        const glm::u64vec3 sum = surface_.colour_sum[run.end] - surface_.colour_sum[run.begin];
        const uint64_t n = run.size();
        return glm::u8vec3((sum + n / 2) / n);
    }

    // ---- hulls: nodes above a group of leaves hold those of full groups, and the larger ones those of
    // groups of groups

    void make_hulls() {
        small_ = make_hulls(kMaxFanOut, [&](uint32_t i, const glm::dvec3& base) {
            const auto shift = glm::vec3(surface_.at[i] - base);
            for (uint32_t k = surface_.corner_begin[i]; k < surface_.rim_end[i]; ++k)
                add_loose(surface_.corners.get(k) + shift);
        });
        large_ = make_hulls(kMaxFanOut * kMaxFanOut, [&](uint32_t i, const glm::dvec3& base) {
            if (i % small_.leaves == 0) add_hull(small_, i / small_.leaves, base);
        });
    }

    // add(i, base): puts what leaf i must cover into loose_.
    template <class Add>
    Hulls make_hulls(int leaves, const Add& add) {
        Hulls hulls{uint32_t(leaves), {}};
        hulls.corners.resize(size_t((surface_.count + hulls.leaves - 1) / hulls.leaves) * Hulls::kCorners);
        size_t to = 0;
        for (uint32_t begin = 0; begin < surface_.count; begin += hulls.leaves) {
            const Run run{begin, std::min(begin + hulls.leaves, surface_.count)};
            loose_count_ = 0;
            for (uint32_t i = run.begin; i < run.end; ++i) add(i, surface_.at[begin]);
            if (loose_.size() < loose_count_ + kSpare) loose_.resize(loose_count_ + kSpare);
            const Frame frame = frame_about(unit_or(normal_of(run), {0, 0, 1}));
            set_prism(extent_of(loose_, 0, loose_count_, frame), frame, hulls.corners, to);
            to += Hulls::kCorners;
        }
        return hulls;
    }

    void add_loose(const glm::vec3& p) {
        if (loose_count_ == loose_.size()) loose_.resize(2 * loose_count_ + 256);
        loose_.set(loose_count_++, p);
    }
    void add_hull(const Hulls& hulls, uint32_t hull, const glm::dvec3& base) {
        const auto shift = glm::vec3(surface_.at[hull * hulls.leaves] - base);
        for (uint32_t k = 0; k < Hulls::kCorners; ++k)
            add_loose(hulls.corners.get(size_t(hull) * Hulls::kCorners + k) + shift);
    }

    // The corners of an octagon by the extents along u, v and the diagonals, at both ends along w.
    static void set_prism(const Extent& x, const Frame& frame, PointArrays& corners, size_t to) {
        const auto add = [&](float u, float v) {
            for (const float w : {x.low[2], x.high[2]})
                corners.set(to++, u * frame.t1 + v * frame.t2 + w * frame.n);
        };
        add(x.high[0], std::min(x.high[1], x.high[3] - x.high[0])),
            add(x.high[0], std::max(x.low[1], x.high[0] - x.high[4]));
        add(x.low[0], std::min(x.high[1], x.low[0] - x.low[4])),
            add(x.low[0], std::max(x.low[1], x.low[3] - x.low[0]));
        add(std::min(x.high[0], x.high[3] - x.high[1]), x.high[1]),
            add(std::max(x.low[0], x.low[4] + x.high[1]), x.high[1]);
        add(std::min(x.high[0], x.high[4] + x.low[1]), x.low[1]),
            add(std::max(x.low[0], x.low[3] - x.low[1]), x.low[1]);
    }

    // ---- groups

    // What holds a run, from its first leaf on: leaf(i), and of a larger run hull(hulls, h).  A prism about a
    // group of leaves would be 3 % larger, and cost a tenth more splats for the same picture.  Runs beside
    // gaps begin and end within hulls, which then do not stand for them.
    template <class OnLeaf, class OnHull>
    void for_parts(const Run& run, const OnLeaf& leaf, const OnHull& hull) const {
        const auto fits = [&](const Hulls& hulls, uint32_t i) {
            return run.size() > hulls.leaves && i % hulls.leaves == 0 &&
                   (i + hulls.leaves <= run.end || run.end == surface_.count);
        };
        for (uint32_t i = run.begin; i < run.end;) {
            if (fits(large_, i))
                hull(large_, i / large_.leaves), i += large_.leaves;
            else if (fits(small_, i))
                hull(small_, i / small_.leaves), i += small_.leaves;
            else
                leaf(i++);
        }
    }

    size_t points_of(const Run& run) const {
        size_t count = 0;
        for_parts(
            run, [&](uint32_t i) { count += corner_end(run, i) - surface_.corner_begin[i]; },
            [&](const Hulls&, uint32_t) { count += Hulls::kCorners; });
        return count;
    }
    // A leaf without some of its siblings needs all its corners.
    uint32_t corner_end(const Run& run, uint32_t leaf) const {
        const uint32_t first = Surface::first_sibling(leaf);
        const bool has_siblings =
            run.begin <= first && std::min(first + uint32_t(kMaxFanOut), surface_.count) <= run.end;
        return has_siblings ? surface_.rim_end[leaf] : surface_.corner_begin[leaf + 1];
    }

    // What child k must hold, relative to the parent's centre.
    void set_points(const Run& run, size_t k, const glm::dvec3& centre) {
        size_t row = 0;
        const auto add = [&](const PointArrays& points, size_t begin, size_t end, uint32_t base) {
            const auto shift = glm::vec3(surface_.at[base] - centre);
            for (size_t i = begin; i < end; ++i) content_.set_point(row++, k, points.get(i) + shift);
        };
        for_parts(
            run, [&](uint32_t i) { add(surface_.corners, surface_.corner_begin[i], corner_end(run, i), i); },
            [&](const Hulls& hulls, uint32_t h) {
                add(hulls.corners, size_t(h) * Hulls::kCorners, size_t(h + 1) * Hulls::kCorners,
                    h * hulls.leaves);
            });
        content_.points[k] = row;
        for (const size_t first = k; row < content_.rows; ++row)
            content_.set_point(row, k, {content_.x[first], content_.y[first], content_.z[first]});
    }

    // Codes the children `runs` of `parent` as a new group.
    void encode_group(std::span<const Run> runs, const Node& parent) {
        content_.count = runs.size();
        size_t rows = 0;
        for (const Run& run : runs) rows = std::max(rows, points_of(run));
        content_.set_rows(rows);
        content_.face_normals = &surface_.face_normals;
        for (size_t k = 0; k < runs.size(); ++k) {
            const auto normal = normal_of(runs[k]);
            content_.normal[k] = unit_or(normal, parent.normal);
            content_.is_leaf[k] = runs[k].size() == 1;
            content_.face_begin[k] = surface_.normal_begin[runs[k].begin],
            content_.face_end[k] = surface_.normal_begin[runs[k].end];
            // A point without a normal has no cone about one.
            if (content_.is_leaf[k] && glm::dot(normal, normal) == 0)
                content_.face_end[k] = content_.face_begin[k];
            set_points(runs[k], k, parent.centre - surface_.base);
        }
        GroupFit fit;
        fit_group(content_, parent, fit);
        tree_.groups.push_back({uint32_t(tree_.size()), uint32_t(runs.size())});
        for (size_t k = 0; k < runs.size(); ++k) {
            counts_.count(fit, k, runs[k].size() == 1);
            tree_.add(fit, k, colour_of(runs[k]), parent);
            runs_.push_back(runs[k]), is_between_.push_back(fit.is_between[k]);
        }
    }

    // The children of a run of at least two leaves; returns how many.
    size_t divide(const Run& run, Run* children) const {
        const uint32_t step = child_leaves(run.size());
        auto side =
            std::lower_bound(gap_sides_.begin(), gap_sides_.end(), run, [](const GapSide& s, const Run& r) {
                return std::tie(s.node_begin, r.end) < std::tie(r.begin, s.node_end);
            });
        size_t n = 0;
        for (uint32_t b = run.begin; b < run.end; b = children[n++].end) {
            while (side != gap_sides_.end() && is_of(*side, run) && side->begin < b) ++side;
            const bool has_side = side != gap_sides_.end() && is_of(*side, run);
            if (has_side && side->begin == b)
                children[n] = {b, side->end};
            else
                children[n] = {b, std::min({b + step, run.end, has_side ? side->begin : run.end})};
        }
        return n;
    }
    static bool is_of(const GapSide& side, const Run& run) {
        return side.node_begin == run.begin && side.node_end == run.end;
    }

    void encode_nodes(const Node& parent) {
        const Run all{0, surface_.count};
        // Full groups take a sixth more nodes than leaves.
        const size_t most = surface_.count + surface_.count / 4 + 64;
        tree_.reserve(most), runs_.reserve(most), is_between_.reserve(most);
        encode_group({&all, 1}, parent);
        for (size_t node = 0; node < tree_.size(); ++node) {
            const Run run = runs_[node];
            Run children[kMaxFanOut];
            size_t n = 0;
            if (is_between_[node]) {
                children[n++] = run;
            } else if (run.size() > 1) {
                n = divide(run, children);
            }
            if (n == 0) continue;
            tree_.child_group[node] = int32_t(tree_.groups.size());
            tree_.attitude[node] = uint16_t(tree_.attitude[node] | n);
            const Node decoded = tree_.decoded[node];
            encode_group({children, n}, decoded);
        }
    }

    // The edges at leaf i that have no partner.
    void note_boundary(uint32_t i, std::vector<glm::u32vec2>& boundary) {
        ++counts_.open_fans;
        std::vector<uint32_t> left, entered;
        for (uint32_t k = surface_.fan_begin[i]; k < surface_.fan_begin[i + 1]; ++k)
            left.push_back(surface_.fan[k].x), entered.push_back(surface_.fan[k].y);
        std::sort(left.begin(), left.end()), std::sort(entered.begin(), entered.end());
        const auto note_lone = [&](const std::vector<uint32_t>& ends, const std::vector<uint32_t>& partners) {
            for (const uint32_t end_of_edge : ends)
                if (!std::binary_search(partners.begin(), partners.end(), end_of_edge))
                    boundary.emplace_back(surface_.leaf[i], surface_.leaf[end_of_edge]);
        };
        note_lone(left, entered), note_lone(entered, left);
    }

    FitCounts& counts_;
    const std::span<const GapSide> gap_sides_;
    const bool has_colour_;
    Surface surface_;
    Hulls small_, large_;
    PointArrays loose_;
    size_t loose_count_ = 0;
    CodedTree tree_;
    std::vector<Run> runs_;            // by node
    std::vector<uint8_t> is_between_;  // by node: its one child has the same leaves
    std::vector<uint32_t> leaf_of_;    // by node
    GroupContent content_;
};

}  // namespace

CodedTree encode_subtree(const SubtreeInput& input, std::span<const GapSide> gap_sides, const Node& parent,
                         FitCounts& counts, std::vector<glm::u32vec2>& boundary) {
    core::ProcessorWatch watch;
    Surface surface = gather_surface(input);
    counts.ms.surface = watch.lap_ms();
    return SubtreeEncoder(std::move(surface), gap_sides, !input.colours.empty(), counts)
        .run(parent, boundary);
}

CodedTree encode_triangles(Surface&& surface, std::span<const GapSide> gap_sides, bool has_colour,
                           const Node& parent, FitCounts& counts) {
    std::vector<glm::u32vec2> none;  // vertices' boundaries are known to gather_triangles()
    return SubtreeEncoder(std::move(surface), gap_sides, has_colour, counts).run(parent, none);
}

}  // namespace splat
