#include "splat/encode.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/share.h"

namespace splat {

namespace {

// Beyond these a level is inserted.  An inner node that is coded too large makes its children small against it, and
// them too large in turn.
constexpr float kMaxLeafInflation = 2.5f, kMaxInnerInflation = 1.6f;
constexpr float kThinWeight = 0.55f;    // what is minimised: R (1 + 0.55 rho); 0.6 is 0.3 dB better and half a percent looser
constexpr float kCoarse = 0.01f;        // of the subtree's radius: below, float corners are too coarse
constexpr float kMinRadius = 1e-12f;    // model units; points closer together than this are one
constexpr float kRoundUp = 1.0001f;    // over the float rounding of decode and cover

glm::vec3 unit_or(const glm::dvec3& v, const glm::vec3& otherwise) {
    const double length = glm::length(v);
    return length > 1e-300 && std::isfinite(length) ? glm::vec3(v / length) : otherwise;
}

// Where in [-1, 1]^2 a direction lies before rounding.
glm::vec2 flatten(const glm::vec3& n, const Frame& frame, int cone) {
    if (cone < 0) {
        const float sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
        const glm::vec2 p(n.x / sum, n.y / sum);
        if (n.z >= 0) return p;
        return {std::copysign(1.0f - std::fabs(p.y), p.x), std::copysign(1.0f - std::fabs(p.x), p.y)};
    }
    const float w = 1.0f + std::max(glm::dot(n, frame.n), -0.99f);
    return glm::vec2(glm::dot(n, frame.t1), glm::dot(n, frame.t2)) / (w * kConeTan[cone]);
}

// The best of the four codes about the direction.
uint32_t encode_normal(const glm::vec3& n, const Frame& frame, int cone) {
    const glm::vec2 p = glm::clamp(flatten(n, frame, cone), -1.0f, 1.0f) * 15.0f + 15.0f;
    const int x = std::min(int(p.x), kNormalSteps - 2), y = std::min(int(p.y), kNormalSteps - 2);
    uint32_t best = 0;
    float best_dot = -2;
    for (int k = 0; k < 4; ++k) {
        const auto code = uint32_t((y + k / 2) * kNormalSteps + x + k % 2);
        const float dot = glm::dot(decode_normal(code, frame, cone), n);
        if (dot > best_dot) best_dot = dot, best = code;
    }
    return best;
}

uint32_t encode_cone(float least_dot, int parent_cone) {
    const int base = parent_cone < 0 ? 0 : parent_cone;
    for (uint32_t code = 0; code < 3; ++code) {
        const int index = decode_cone(int(code), parent_cone);
        if (index >= base && kConeCos[index] <= least_dot - 2e-6f) return code;
    }
    return 3;
}

struct Choice {
    uint32_t place = kRadiusLevels - 1u, shape = 3;
    float cost = std::numeric_limits<float>::infinity();
};

// The step at or below `x` (in parts of the limit), so that it and the next lie about it.  `linear`: slope of
// the steps at the middle.
int step_below(float x, int count, float scale, float linear) {
    const float a = std::min(std::fabs(x), 1.0f);
    const float u = (std::sqrt(linear * linear + 4 * (1 - linear) * a) - linear) / (2 * (1 - linear));
    const float index = std::copysign(u, x) * scale + 0.5f * float(count - 1);
    return std::clamp(int(index + 1e-3f), 0, count - 2);
}

// What is to be covered, and by whose child.
struct Search {
    const FramePoints& points;
    glm::vec3 ideal;
    float smallest;  // radius of the sphere about it
    float parent_radius;
};

// Tries the eight lattice points of the cell from step (a, b, c) on.  Where all of them are further than `bound` (the
// square) from the ideal centre nothing is tried.
void try_cell(int level, int a, int b, int c, float bound, const Search& search, Choice& best) {
    const float radius = kRadius[level] * search.parent_radius;
    const float allowed = radius * radius / (kRoundUp * kRoundUp);
    const LatticeCell cell{{across_step(a), across_step(a + 1)}, {across_step(b), across_step(b + 1)}, {along_step(c), along_step(c + 1)},
                           centre_limit(level), search.parent_radius, allowed, search.ideal};
    Cover8 needed;
    if (!cover_lattice(search.points, cell, bound, needed)) return;
    for (int k = 0; k < int(kLanes); ++k) {
        for (uint32_t rho = 0; rho < 4; ++rho) {
            if (!(needed.square[rho][k] <= allowed)) continue;
            const float cost = radius * (1.0f + kThinWeight * kFlatness[rho]) *
                               (1.0f + 1e-3f * needed.square[rho][k] / allowed);  // among equals, the best centred
            const int across = a + (k & 1) + kAcrossSteps * (b + (k >> 1 & 1));
            if (cost < best.cost) best = {uint32_t(level | across << 4 | (c + (k >> 2)) << 11), rho, cost};
            break;
        }
    }
}

// Tries the lattice points about the ideal centre on one level.
void try_level(int level, const Search& search, Choice& best) {
    const float radius = kRadius[level] * search.parent_radius;
    const float scale = 1.0f / std::max(centre_limit(level) * search.parent_radius, std::numeric_limits<float>::min());
    // About the centre of the smallest sphere, points are as far off on all sides: a step aside costs at least
    // its square.  (The centre is not exact: 1 / 0.95.)
    const bool is_last = level == kRadiusLevels - 1;
    const float bound = is_last ? std::numeric_limits<float>::infinity() : radius * radius / 0.95f - search.smallest * search.smallest;
    try_cell(level, step_below(search.ideal.x * scale, kAcrossSteps, 5, kAcrossLinear),
             step_below(search.ideal.y * scale, kAcrossSteps, 5, kAcrossLinear),
             step_below(search.ideal.z * scale, kAlongSteps, 16, kAlongLinear), bound, search, best);
}

// For the few leaves at the rim of their parent whose best centre is not the nearest to the ideal one: the whole
// lattice, up to the first level that has a cover.
void try_everything(const Search& search, Choice& best) {
    constexpr float kAnywhere = std::numeric_limits<float>::infinity();
    for (int level = 0; level < kRadiusLevels - 1; ++level) {
        if (kRadius[level] * search.parent_radius < search.smallest) continue;
        for (int a = 0; a < kAcrossSteps - 1; ++a)
            for (int b = 0; b < kAcrossSteps - 1; ++b)
                for (int c = 0; c < kAlongSteps; c += 2) try_cell(level, a, b, c, kAnywhere, search, best);
        if (int(best.place & 15u) == level) return;
    }
}

// Middle of the smallest circle across, nearly, and of the thickness.
glm::vec3 free_centre(const Extent& e) {
    const auto middle = [&](int k) { return 0.5f * (e.low[k] + e.high[k]); };
    const float sum = middle(3), difference = middle(4);
    return {0.5f * (middle(0) + 0.5f * (sum + difference)), 0.5f * (middle(1) + 0.5f * (sum - difference)), middle(2)};
}

}  // namespace

void FitCounts::add(const FitCounts& o) {
    inserted += o.inserted, leaves += o.leaves, inner += o.inner;
    leaf_inflation += o.leaf_inflation, inner_inflation += o.inner_inflation;
    worst_leaf_inflation = std::max(worst_leaf_inflation, o.worst_leaf_inflation);
    open_fans += o.open_fans;
}

NodeEncoder::Result NodeEncoder::encode(const Content& content, const Node& parent, const Frame& parent_frame) {
    Result result;
    const glm::vec3 wanted = unit_or(content.normal, parent.normal);
    const uint32_t normal = encode_normal(wanted, parent_frame, parent.cone);
    const Frame frame = frame_about(decode_normal(normal, parent_frame, parent.cone));
    const uint32_t cone =
        content.face_normals && content.face_end > content.face_begin
            ? encode_cone(least_dot(*content.face_normals, content.face_begin, content.face_end, frame.n), parent.cone)
            : 3;

    Extent extent;
    if (content.precise) {
        exact_.clear();
        for (size_t i = content.begin; i < content.end; ++i)
            exact_.push(glm::vec3(content.base + (*content.precise)[i] - parent.centre));
        exact_.spare();
        extent = rotate(exact_, 0, content.end - content.begin, glm::vec3(0), frame, points_);
    } else {
        extent = rotate(*content.points, content.begin, content.end, glm::vec3(parent.centre - content.base), frame, points_);
    }
    const glm::vec3 ideal = free_centre(extent);
    const float smallest = std::max(std::sqrt(farthest_square(points_, ideal)), std::min(kMinRadius, parent.radius));

    const Search search{points_, ideal, smallest, parent.radius};
    Choice best;
    for (int level = 0; level < kRadiusLevels; ++level) {
        const float radius = kRadius[level] * parent.radius;
        if (radius < smallest && level < kRadiusLevels - 1) continue;
        if (radius * (1.0f + kThinWeight * kFlatness[0]) >= best.cost) break;
        try_level(level, search, best);
    }
    const float largest = content.is_leaf ? kMaxLeafInflation : kMaxInnerInflation;
    if (content.is_leaf && parent.radius > largest * smallest && (best.place & 15u) == kRadiusLevels - 1u) try_everything(search, best);
    const int level = int(best.place & 15u);
    result.attitude = uint16_t(cone << 3 | normal << 5);
    result.place = uint16_t(best.place);
    result.shape = uint8_t(best.shape);
    result.colour = encode_colour(content.colour);
    result.node = decode_node(result.attitude, result.place, result.shape, result.colour, parent, parent_frame);
    result.inflation = result.node.radius / smallest;
    result.is_between = result.inflation > largest && level < kRadiusLevels - 1;
    return result;
}

static uint32_t quantise_error(float error, float radius) {
    for (uint32_t code = 0; code < 8; ++code)
        if (error <= radius * kErrorOfRadius[code]) return code;
    return 7;
}

void set_error(CodedTree& tree, size_t node, float error) {
    const uint32_t code = quantise_error(error, tree.decoded[node].radius);
    tree.attitude[node] = uint16_t((tree.attitude[node] & 0x7fffu) | code >> 2 << 15);
    tree.shape[node] = uint8_t((tree.shape[node] & 3u) | (code & 3u) << 2);
    tree.decoded[node].error = tree.decoded[node].radius * kErrorOfRadius[code];
}

float error_over(const Node& node, std::span<const Node* const> parts) {
    constexpr size_t kMost = 64;
    const Frame frame = frame_about(node.normal);
    ChildShape shapes[kMost];
    const auto turn = [&](const glm::vec3& v) {
        return glm::vec3(glm::dot(frame.t1, v), glm::dot(frame.t2, v), glm::dot(frame.n, v));
    };
    const size_t count = std::min(parts.size(), kMost);
    for (size_t k = 0; k < count; ++k) {
        const Node& c = *parts[k];
        shapes[k] = {turn(glm::vec3(c.centre - node.centre)), turn(c.normal), c.radius, c.error};
    }
    return nested_error(node.radius, {shapes, count}) * kRoundUp;
}

namespace {

// The surface of one subtree, leaf by leaf, as the encoder wants it.
class SubtreeEncoder {
  public:
    SubtreeEncoder(const SubtreeInput& input, FitCounts& counts, std::vector<glm::u32vec2>& boundary)
        : in_(input), count_(input.end - input.begin), base_(input.model(input.begin)), counts_(counts), boundary_(boundary) {}

    CodedTree run(const Node& parent) {
        gather_incidences();
        gather_surface();
        encode_nodes(parent);
        set_errors();
        // What stays until the file is written is kept small.
        tree_.decoded = std::vector<Node>{tree_.decoded[0]};
        for (auto* codes : {&tree_.attitude, &tree_.place, &tree_.colour}) codes->shrink_to_fit();
        tree_.shape.shrink_to_fit(), tree_.child_group.shrink_to_fit(), tree_.groups.shrink_to_fit();
        if (in_.colours.empty()) std::vector<uint16_t>().swap(tree_.colour);
        return std::move(tree_);
    }

  private:
    // The faces at each leaf as pairs (p, q) of the other two corners, in the face's sense.  Corners are
    // numbered: leaves of the subtree by their place in it, others as they come.
    void gather_incidences() {
        pair_begin_.assign(count_ + 1, 0);
        near_.clear(), near_leaf_.clear();
        for (uint32_t i = 0; i < count_; ++i) near_.push_back(in_.model(in_.begin + i) - base_), near_leaf_.push_back(in_.begin + i);
        std::vector<glm::u32vec3> corners(in_.faces.size());
        for (size_t f = 0; f < corners.size(); ++f)
            for (int k = 0; k < 3; ++k) {
                corners[f][k] = number_of(in_.faces[f][k]);
                if (corners[f][k] < count_) ++pair_begin_[corners[f][k] + 1];
            }
        for (uint32_t i = 0; i < count_; ++i) pair_begin_[i + 1] += pair_begin_[i];
        pairs_.resize(pair_begin_[count_]);
        std::vector<uint32_t> at(pair_begin_.begin(), pair_begin_.end() - 1);
        for (const glm::u32vec3& c : corners)
            for (int k = 0; k < 3; ++k)
                if (c[k] < count_) pairs_[at[c[k]]++] = {c[(k + 1) % 3], c[(k + 2) % 3]};
        fan_.p.resize(pairs_.size() + kLanes), fan_.q.resize(pairs_.size() + kLanes);
        for (size_t k = 0; k < pairs_.size(); ++k)
            fan_.p.set(k, glm::vec3(near_[pairs_[k].x])), fan_.q.set(k, glm::vec3(near_[pairs_[k].y]));
    }

    // Open addressing: strangers are few, and looked up often.
    uint32_t number_of(uint32_t leaf) {
        if (leaf - in_.begin < count_) return leaf - in_.begin;  // wraps where it is below begin
        if (2 * (near_.size() - count_) >= strangers_.size()) rehash(std::max<size_t>(256, 2 * strangers_.size()));
        size_t slot = mix(leaf) >> 32 & (strangers_.size() - 1);
        while (strangers_[slot] != 0 && near_leaf_[strangers_[slot]] != leaf) slot = (slot + 1) & (strangers_.size() - 1);
        if (strangers_[slot] == 0) {
            strangers_[slot] = uint32_t(near_.size());  // never 0: number 0 is a leaf of ours
            near_.push_back(in_.model(leaf) - base_), near_leaf_.push_back(leaf);
        }
        return strangers_[slot];
    }
    void rehash(size_t size) {
        strangers_.assign(size, 0);
        for (size_t n = count_; n < near_.size(); ++n) {
            size_t slot = mix(near_leaf_[n]) >> 32 & (size - 1);
            while (strangers_[slot] != 0) slot = (slot + 1) & (size - 1);
            strangers_[slot] = uint32_t(n);
        }
    }

    void gather_surface() {
        corner_begin_.assign(1, 0), normal_begin_.assign(1, 0);
        normals_.clear();
        colour_sum_.assign(1, glm::u64vec3(0));
        for (uint32_t i = 0; i < count_; ++i) {
            const uint32_t leaf = in_.begin + i;
            const uint32_t vertex = in_.points[leaf].vertex;
            const glm::dvec3 at = near_[i];
            glm::dvec3 normal = in_.cloud_radii.empty() ? add_faces(i, at) : add_disc(vertex, at);
            if (!in_.normals.empty()) {
                const glm::dvec3 given(in_.normals[vertex]);
                const double weight = glm::length(normal);
                if (glm::dot(given, given) > 0.25) {
                    normal = given * (weight > 0 ? weight : 1.0);
                    face_normals_.push(in_.normals[vertex]);
                }
            }
            if (face_normals_.size() == normal_begin_.back()) face_normals_.push(unit_or(normal, {0, 0, 1}));
            corner_begin_.push_back(corners_.size());
            normal_begin_.push_back(face_normals_.size());
            normals_.push_back(normal);
            colour_sum_.push_back(colour_sum_.back() + glm::u64vec3(in_.colours.empty() ? glm::u8vec3(0) : in_.colours[vertex]));
        }
        corners_.spare(), face_normals_.spare();
    }

    void add_corner(const glm::dvec3& p) {
        corners_.push(glm::vec3(p));
        precise_.push_back(p);
    }
    // Share corners and face normals of leaf i; returns the area-weighted normal.
    glm::dvec3 add_faces(uint32_t i, const glm::dvec3& at) {
        glm::dvec3 sum(0);
        add_corner(at);
        for (uint32_t k = pair_begin_[i]; k < pair_begin_[i + 1]; ++k) {
            const glm::dvec3 p = near_[pairs_[k].x] - at, q = near_[pairs_[k].y] - at;
            const Share share = share_of(p, q);
            for (int c = 0; c < share.count; ++c) add_corner(at + share.corner[c]);
            const glm::dvec3 cross = glm::cross(p, q);
            const double area2 = glm::length(cross);
            if (area2 > 1e-12 * glm::dot(p, p) + 1e-290) face_normals_.push(glm::vec3(cross / area2));
            sum += cross;
        }
        return sum;
    }

    // A bare point covers a disc across its normal (a ball's octahedron where it has none).
    glm::dvec3 add_disc(uint32_t vertex, const glm::dvec3& at) {
        const double radius = double(in_.cloud_radii[vertex]) * in_.inverse_scale;
        const glm::vec3 n = in_.normals.empty() ? glm::vec3(0) : in_.normals[vertex];
        if (glm::dot(n, n) < 0.25f) {
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {-1.0, 1.0}) {
                    glm::dvec3 p = at;
                    p[axis] += sign * radius;
                    add_corner(p);
                }
            return glm::dvec3(0);
        }
        const Frame frame = frame_about(n);
        for (int k = 0; k < 8; ++k) {
            const double phi = k * 0.78539816339744831;
            add_corner(at + radius / 0.92387953251128674 * (std::cos(phi) * glm::dvec3(frame.t1) + std::sin(phi) * glm::dvec3(frame.t2)));
        }
        return glm::dvec3(n) * (radius * radius);
    }

    // A run of leaves that is to become a node.
    struct Run {
        uint32_t begin, end;
        bool is_between;  // the node only stands between: its one child has the same leaves
    };

    // Area-weighted, of leaves [begin, end).  Not by differences of running sums: beside faces of a landscape
    // those of a pebble are lost in their rounding.
    glm::dvec3 normal_of(uint32_t begin, uint32_t end) const {
        glm::dvec3 sum(0);
        for (uint32_t i = begin; i < end; ++i) sum += normals_[i];
        return sum;
    }

    // Above the groups of leaves, prisms that hold a group's corners each stand for them.
    void gather_hulls() {
        FramePoints turned;
        for (uint32_t b = 0; b < count_; b += kMaxFanOut) {
            const uint32_t e = std::min(b + uint32_t(kMaxFanOut), count_);
            const Frame frame = frame_about(unit_or(normal_of(b, e), {0, 0, 1}));
            const Extent extent = rotate(corners_, corner_begin_[b], corner_begin_[e], glm::vec3(0), frame, turned);
            add_prism(extent, frame);
        }
        hulls_.spare();
    }

    // The corners of an octagon by the extents along u, v and the diagonals, at both ends along w.
    void add_prism(const Extent& x, const Frame& frame) {
        const auto add = [&](float u, float v) {
            for (const float w : {x.low[2], x.high[2]}) hulls_.push(u * frame.t1 + v * frame.t2 + w * frame.n);
        };
        add(x.high[0], std::min(x.high[1], x.high[3] - x.high[0])), add(x.high[0], std::max(x.low[1], x.high[0] - x.high[4]));
        add(x.low[0], std::min(x.high[1], x.low[0] - x.low[4])), add(x.low[0], std::max(x.low[1], x.low[3] - x.low[0]));
        add(std::min(x.high[0], x.high[3] - x.high[1]), x.high[1]), add(std::max(x.low[0], x.low[4] + x.high[1]), x.high[1]);
        add(std::min(x.high[0], x.high[4] + x.low[1]), x.low[1]), add(std::max(x.low[0], x.low[3] - x.low[1]), x.low[1]);
    }

    Content content_of(const Run& run) const {
        Content c{&corners_, corner_begin_[run.begin], corner_begin_[run.end], base_};
        if (run.end - run.begin > uint32_t(kMaxFanOut) && !is_precise_) {
            constexpr size_t kPrism = 16;
            c.points = &hulls_;
            c.begin = run.begin / kMaxFanOut * kPrism;
            c.end = (run.end + kMaxFanOut - 1) / kMaxFanOut * kPrism;
        }
        c.is_leaf = run.end - run.begin == 1;
        c.normal = normal_of(run.begin, run.end);
        c.face_normals = &face_normals_;
        c.face_begin = normal_begin_[run.begin], c.face_end = normal_begin_[run.end];
        const glm::u64vec3 sum = colour_sum_[run.end] - colour_sum_[run.begin];
        const uint64_t n = run.end - run.begin;
        c.colour = glm::u8vec3((sum + n / 2) / n);
        return c;
    }

    // Codes the children `runs` of `parent` as a new group.
    void encode_group(std::span<const Run> runs, const Node& parent) {
        const Frame frame = frame_about(parent.normal);
        tree_.groups.push_back({uint32_t(tree_.size()), uint32_t(runs.size())});
        for (Run run : runs) {
            // Far below the subtree's size the float corners are too coarse.
            is_precise_ = parent.radius < kCoarse * subtree_radius_;
            Content content = content_of(run);
            if (is_precise_) content.precise = &precise_;
            const NodeEncoder::Result r = encoder_.encode(content, parent, frame);
            run.is_between = r.is_between;
            const bool is_leaf = run.end - run.begin == 1 && !r.is_between;
            count(r, is_leaf);
            tree_.attitude.push_back(r.attitude);
            tree_.place.push_back(r.place);
            tree_.shape.push_back(r.shape);
            tree_.colour.push_back(r.colour);
            tree_.child_group.push_back(CodedTree::kLeaf);
            tree_.decoded.push_back(r.node);
            runs_.push_back(run);
        }
    }

    void count(const NodeEncoder::Result& r, bool is_leaf) {
        if (r.is_between) {
            ++counts_.inserted;
        } else if (is_leaf) {
            ++counts_.leaves;
            counts_.leaf_inflation += double(r.inflation);
            counts_.worst_leaf_inflation = std::max(counts_.worst_leaf_inflation, r.inflation);
        } else {
            ++counts_.inner;
            counts_.inner_inflation += double(r.inflation);
        }
    }

    void encode_nodes(const Node& parent) {
        subtree_radius_ = 0;
        for (const glm::dvec3& p : precise_) subtree_radius_ = std::max(subtree_radius_, float(glm::length(p)));
        gather_hulls();
        const Run all{0, count_, false};
        encode_group({&all, 1}, parent);
        for (size_t node = 0; node < tree_.size(); ++node) {
            const Run run = runs_[node];
            Run children[kMaxFanOut];
            size_t n = 0;
            if (run.is_between) {
                children[n++] = {run.begin, run.end, false};
            } else if (run.end - run.begin > 1) {
                const uint32_t step = child_leaves(run.end - run.begin);
                for (uint32_t b = run.begin; b < run.end; b += step) children[n++] = {b, std::min(b + step, run.end), false};
            }
            if (n == 0) continue;
            tree_.child_group[node] = int32_t(tree_.groups.size());
            tree_.attitude[node] = uint16_t(tree_.attitude[node] | n);
            const Node decoded = tree_.decoded[node];
            encode_group({children, n}, decoded);
        }
    }

    void set_errors() {
        is_closed_.resize(count_);
        for (uint32_t i = 0; i < count_; ++i) is_closed_[i] = find_closed(i);
        find_neighbours();
        for (size_t node = tree_.size(); node-- > 0;) {
            if (tree_.child_group[node] == CodedTree::kLeaf)
                set_error(tree_, node, leaf_error(runs_[node].begin, tree_.decoded[node]));
            else
                set_error(tree_, node, inner_error(node));
        }
    }

    template <class Use>
    void for_children(size_t node, const Use& use) const {
        if (tree_.child_group[node] == CodedTree::kLeaf) return;
        const auto [first, n] = tree_.groups[size_t(tree_.child_group[node])];
        for (uint32_t k = 0; k < n; ++k) use(first + k);
    }

    bool touch(size_t a, size_t b) const {
        const Node &p = tree_.decoded[a], &q = tree_.decoded[b];
        const glm::vec3 d(p.centre - q.centre);
        const float reach = p.radius + q.radius;
        return glm::dot(d, d) < reach * reach;
    }

    // For each inner node the nodes of its level whose spheres touch its own, itself first: found among the
    // children of its parent's neighbours.
    void find_neighbours() {
        neighbour_begin_.assign(tree_.size() + 1, 0);
        neighbours_.clear();
        const auto close = [&](size_t node) { neighbour_begin_[node + 1] = uint32_t(neighbours_.size()); };
        neighbours_.push_back(0);
        close(0);
        std::vector<uint32_t> parent(tree_.size(), 0);
        for (uint32_t node = 0; node < tree_.size(); ++node) for_children(node, [&](uint32_t c) { parent[c] = node; });
        for (uint32_t node = 1; node < tree_.size(); ++node) {
            if (tree_.child_group[node] != CodedTree::kLeaf) {
                neighbours_.push_back(node);
                for (uint32_t k = neighbour_begin_[parent[node]]; k < neighbour_begin_[parent[node] + 1]; ++k) {
                    const uint32_t uncle = neighbours_[k];
                    for_children(uncle, [&](uint32_t c) {
                        if (c != node && touch(c, node)) neighbours_.push_back(c);
                    });
                }
            }
            close(node);
        }
    }

    // The node's disc reaches over the rim of its surface, where its neighbours' is.
    float inner_error(size_t node) {
        parts_.clear();
        for (uint32_t k = neighbour_begin_[node]; k < neighbour_begin_[node + 1]; ++k) {
            const uint32_t n = neighbours_[k];
            for_children(n, [&](uint32_t c) {
                if (n == node || touch(c, node)) parts_.push_back(&tree_.decoded[c]);
            });
        }
        return error_over(tree_.decoded[node], parts_);
    }

    // Bound on the distance from any point of a leaf's disc to the surface.
    //
    // The faces about a set of closed vertices are taken, beginning with the leaf's own, until no edge of
    // their rim crosses the disc.  If all of them are seen from the normal's side, their projection covers
    // the whole disc (its degree over the disc is constant, and positive at the vertex), so that over each
    // point of the disc there is surface, no further up or down than the faces that meet the disc go.
    // Where the faces do not close or fold over, it is the distance to the faces at the vertex.
    float leaf_error(uint32_t i, const Node& node) {
        constexpr size_t kMostVertices = 16, kMostFaces = 64;
        const glm::dvec3 centre = node.centre - base_;
        const float to_vertex = float(glm::length(near_[i] - centre) + double(node.radius)) * kRoundUp;
        const float rounding = 4e-7f * subtree_radius_;  // of the float corners
        if (node.radius < 1e3f * rounding) return to_vertex;
        const Frame frame = frame_about(node.normal);
        const auto by_own_faces = [&] {
            const float error = fan_error(fan_, pair_begin_[i], pair_begin_[i + 1], glm::vec3(near_[i]), glm::vec3(centre), frame, node.radius);
            return std::min(error * kRoundUp + rounding, to_vertex);
        };
        float height = 0;
        patch_.assign(1, i);
        for (size_t at = 0; at < patch_.size(); ++at) {
            const uint32_t vertex = patch_[at];
            if (vertex >= count_ || !is_closed_[vertex]) return by_own_faces();
            const uint32_t begin = pair_begin_[vertex], end = pair_begin_[vertex + 1];
            if (patch_.size() > kMostVertices || end - begin > kMostFaces) return by_own_faces();
            FanView fan = view_fan(fan_, begin, end, glm::vec3(near_[vertex]), glm::vec3(centre), frame, node.radius);
            if (fan.is_folded) return by_own_faces();
            height = std::max(height, fan.height);
            const auto has = [&](uint32_t x) { return std::find(patch_.begin(), patch_.end(), x) != patch_.end(); };
            for (; fan.crossing; fan.crossing &= fan.crossing - 1) {
                const glm::u32vec2 edge = pairs_[begin + uint32_t(__builtin_ctzll(fan.crossing))];
                if (!has(edge.x) && !has(edge.y)) patch_.push_back(edge.x);
            }
        }
        return std::min(height * kRoundUp + rounding, to_vertex);
    }

    // Do the faces go round leaf i and close?  If not, notes the edges without a partner.
    bool find_closed(uint32_t i) {
        uint64_t out = 0, in = 0;  // sums of hashes: equal where each edge is left as often as entered
        for (uint32_t k = pair_begin_[i]; k < pair_begin_[i + 1]; ++k) out += mix(pairs_[k].x), in += mix(pairs_[k].y);
        if (out == in) return pair_begin_[i] < pair_begin_[i + 1];
        ++counts_.open_fans;
        std::vector<uint32_t> left, entered;
        for (uint32_t k = pair_begin_[i]; k < pair_begin_[i + 1]; ++k) left.push_back(pairs_[k].x), entered.push_back(pairs_[k].y);
        std::sort(left.begin(), left.end()), std::sort(entered.begin(), entered.end());
        for (uint32_t k = pair_begin_[i]; k < pair_begin_[i + 1]; ++k) {
            const auto [x, y] = std::pair(pairs_[k].x, pairs_[k].y);
            if (!std::binary_search(entered.begin(), entered.end(), x)) boundary_.emplace_back(in_.begin + i, near_leaf_[x]);
            if (!std::binary_search(left.begin(), left.end(), y)) boundary_.emplace_back(in_.begin + i, near_leaf_[y]);
        }
        return false;
    }
    static uint64_t mix(uint64_t x) {
        x = (x + 1) * 0x9e3779b97f4a7c15u;
        return x ^ x >> 29;
    }

    const SubtreeInput& in_;
    const uint32_t count_;
    const glm::dvec3 base_;
    FitCounts& counts_;
    std::vector<glm::u32vec2>& boundary_;
    NodeEncoder encoder_;
    CodedTree tree_;
    float subtree_radius_ = 0;
    std::vector<Run> runs_;
    std::vector<uint32_t> pair_begin_, patch_;
    std::vector<glm::dvec3> near_;        // corners of the faces, relative to base_
    std::vector<uint32_t> near_leaf_, strangers_;
    std::vector<uint8_t> is_closed_;
    std::vector<uint32_t> neighbour_begin_, neighbours_;
    std::vector<const Node*> parts_;
    std::vector<glm::u32vec2> pairs_;
    PointArrays corners_, face_normals_, hulls_;
    FanArrays fan_;
    bool is_precise_ = false;
    std::vector<glm::dvec3> precise_;
    std::vector<size_t> corner_begin_, normal_begin_;
    std::vector<glm::dvec3> normals_;  // by leaf
    std::vector<glm::u64vec3> colour_sum_;
};

}  // namespace

CodedTree encode_subtree(const SubtreeInput& input, const Node& parent, FitCounts& counts,
                         std::vector<glm::u32vec2>& boundary) {
    return SubtreeEncoder(input, counts, boundary).run(parent);
}

}  // namespace splat
