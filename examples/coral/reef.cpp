#include "reef.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "noise.h"

namespace coral {

namespace {

// By how much the relief of a material may move the surface; field() promises it to narrow().
constexpr float kMaxRelief = 0.03f;
// How fast distances can change with the place: 1 for a plain one; tapering adds to a segment's, melting
// to the blend's.
constexpr float kSegmentSteepness = 1.1f;
constexpr float kSteepness = 1.3f;
// The furthest that a surface reaches out to melt into its neighbours.  Thin strands reach less, so as
// to keep their shape.
constexpr float kMelt = 0.03f;
float melt(float radius) {
    return std::min(0.9f * radius, kMelt);
}

float smooth_step(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

struct Hit {
    float distance, radius, age;
};

Hit measure(const Segment& s, glm::vec3 p) {
    const glm::vec3 ap = p - s.a;
    const float t = std::clamp(glm::dot(ap, s.ab) * s.inverse_length2, 0.0f, 1.0f);
    const float radius = s.radius_a + (s.radius_b - s.radius_a) * t;
    return {glm::length(ap - s.ab * t) - radius, radius, s.age_a + (s.age_b - s.age_a) * t};
}

// Winding grooves: the sheet sin x cos y + ... of the gyroid, cut by the surface.  In [-1, 1].
float maze(glm::vec3 p) {
    const glm::vec3 q = p * 118.0f + 2.2f * glm::vec3(value_noise(p * 14.0f), value_noise(p * 14.0f + 31.0f),
                                                      value_noise(p * 14.0f + 67.0f));
    const float g =
        std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
    return std::tanh(2.2f * g);
}

// The cups in which polyps sit: a rim round a pit, 0 between them.
float cups(glm::vec3 p, float size) {
    const float r = nearest_point(p / size);
    return smooth_step(0.62f, 0.40f, r) - 1.5f * smooth_step(0.30f, 0.10f, r);
}

// Outward shift of the surface, at most kMaxRelief.
float relief(Material material, float age, glm::vec3 p) {
    switch (material) {
        case kRock: {
            const float lumps = fractal_noise(p * 9.0f, 6);
            const float holes = smooth_step(0.42f, 0.15f, nearest_point(p * 34.0f + 3.0f * lumps));
            return 0.022f * lumps - 0.006f * holes * smooth_step(-0.1f, 0.3f, value_noise(p * 7.0f));
        }
        case kBrain:
            return 0.0055f * maze(p) + 0.0008f * value_noise(p * 420.0f);
        case kBranch:
            return 0.0032f * (1 - 0.5f * age) * cups(p, 0.017f) + 0.0006f * value_noise(p * 300.0f);
        case kAnemone:
            return 0.0005f * std::sin(age * 160.0f);
        default:
            return 0;
    }
}

using Colour = glm::vec3;

Colour colour_of(Material material, float age, glm::vec3 p) {
    switch (material) {
        case kRock: {
            const float patch = smooth_step(0.0f, 0.35f, fractal_noise(p * 6.0f + 40.0f, 4));
            const float moss = smooth_step(0.05f, 0.3f, fractal_noise(p * 11.0f + 90.0f, 4));
            Colour c = glm::mix(Colour(0.50f, 0.45f, 0.38f), Colour(0.62f, 0.33f, 0.42f), patch);
            c = glm::mix(c, Colour(0.36f, 0.42f, 0.22f), 0.7f * moss);
            return c * (1.25f + 0.45f * fractal_noise(p * 60.0f, 3) + 0.5f * fractal_noise(p * 9.0f, 4));
        }
        case kBrain:
            return glm::mix(Colour(0.14f, 0.36f, 0.33f), Colour(0.88f, 0.76f, 0.36f), 0.5f + 0.5f * maze(p));
        case kBranch: {
            const Colour stem = glm::mix(Colour(0.50f, 0.10f, 0.34f), Colour(0.95f, 0.40f, 0.34f),
                                         smooth_step(0.0f, 0.75f, age));
            const Colour c = glm::mix(stem, Colour(1.0f, 0.93f, 0.80f), smooth_step(0.80f, 1.0f, age));
            return c * (0.96f + 0.22f * cups(p, 0.017f));
        }
        case kFan:
            return glm::mix(Colour(0.42f, 0.16f, 0.58f), Colour(0.98f, 0.72f, 0.30f),
                            smooth_step(0.55f, 1.0f, age));
        case kAnemone:
            return glm::mix(Colour(0.10f, 0.46f, 0.44f), Colour(0.98f, 0.60f, 0.80f),
                            smooth_step(0.45f, 1.0f, age));
        default:
            return glm::mix(Colour(0.13f, 0.07f, 0.20f), Colour(0.60f, 0.24f, 0.32f), age);
    }
}

// A tree as it grew: nodes in the order of growth, parents first.
struct Tree {
    std::vector<glm::vec3> at;
    std::vector<int> parent;
};

// Space colonisation (Runions, Lane, Prusinkiewicz.  Modeling trees with a space colonization
// algorithm.  2007): every target pulls the nearest node, nodes that are pulled grow by `step`, a
// target is used up when a node comes within `reach`.
Tree colonise(glm::vec3 root, std::vector<glm::vec3> targets, float step, float reach) {
    Tree tree{{root}, {-1}};
    struct Pull {
        int node = 0;
        float distance = 1e9f;
    };
    std::vector<Pull> pulls(targets.size());
    size_t seen = 0;  // nodes that the pulls know of
    for (int round = 0; round < 400; ++round) {
        const size_t count = tree.at.size();
        std::vector<glm::vec3> sum(count, glm::vec3(0));
        for (size_t i = 0; i < targets.size(); ++i) {
            Pull& pull = pulls[i];
            for (size_t n = seen; n < count; ++n) {
                const float d = glm::distance(tree.at[n], targets[i]);
                if (d < pull.distance) pull = {static_cast<int>(n), d};
            }
            if (pull.distance > reach)
                sum[static_cast<size_t>(pull.node)] +=
                    (targets[i] - tree.at[static_cast<size_t>(pull.node)]) / pull.distance;
        }
        seen = count;
        for (size_t n = 0; n < count; ++n) {
            if (!(glm::length(sum[n]) > 0)) continue;
            // Targets that pull to opposite sides make a node grow to and fro for ever.
            const glm::vec3 next = tree.at[n] + step * glm::normalize(sum[n]);
            if (std::ranges::any_of(tree.at,
                                    [&](glm::vec3 p) { return glm::distance(p, next) < 0.5f * step; }))
                continue;
            tree.at.push_back(next);
            tree.parent.push_back(static_cast<int>(n));
        }
        if (tree.at.size() == count) break;
    }
    return tree;
}

// Twigs shorter than this many nodes are cut off: what is left where two branches met.
std::vector<bool> worth_keeping(const Tree& tree, int fewest) {
    const size_t count = tree.at.size();
    std::vector<int> height(count, 1);
    for (size_t n = count; n-- > 1;) {
        const size_t p = static_cast<size_t>(tree.parent[n]);
        height[p] = std::max(height[p], height[n] + 1);
    }
    std::vector<bool> keep(count, true);
    for (size_t n = 1; n < count; ++n) {
        const size_t p = static_cast<size_t>(tree.parent[n]);
        const bool is_twig = height[n] < fewest && height[p] > height[n] + 1;
        keep[n] = keep[p] && !is_twig;
    }
    return keep;
}

}  // namespace

Reef::Reef() {
    add_rock();
    add_branching_coral();
    add_fan({-0.36f, 0.14f, -0.17f}, 0.5f, 0.62f, 11);
    add_fan({0.33f, 0.14f, -0.22f}, -0.7f, 0.44f, 12);
    add_anemone({0.36f, 0.215f, 0.21f}, 21);
    add_urchin({-0.22f, 0.245f, 0.345f}, 0.034f, 31);
    add_urchin({0.13f, 0.235f, 0.375f}, 0.026f, 32);
    // blend() takes neighbours in the list to be of one strand.
    std::ranges::stable_sort(segments_, {}, &Segment::strand);
}

void Reef::add(glm::vec3 a, glm::vec3 b, float radius_a, float radius_b, float age_a, float age_b,
               uint32_t strand, Material material) {
    const glm::vec3 ab = b - a;
    const float length2 = glm::dot(ab, ab);
    segments_.push_back(
        {a, ab, length2 > 0 ? 1 / length2 : 0, radius_a, radius_b, age_a, age_b, strand, material});
}

void Reef::add_ball(glm::vec3 centre, float radius, Material material) {
    add(centre, centre, radius, radius, 0, 0, new_strand(), material);
}

void Reef::add_rock() {
    Random random(1);
    for (int i = 0; i < 26; ++i) {
        const float turn = 2 * std::numbers::pi_v<float> * random.unit(), out = std::sqrt(random.unit());
        const float radius = random.within(0.09f, 0.15f) * (1.25f - 0.5f * out);
        add_ball({0.44f * out * std::cos(turn), 0.09f - 0.05f * out, 0.34f * out * std::sin(turn)}, radius,
                 kRock);
    }
    // What the anemone and the fans stand on.
    add_ball({0.36f, 0.06f, 0.20f}, 0.115f, kRock);
    add_ball({-0.36f, 0.06f, -0.17f}, 0.115f, kRock);
    add_ball({0.33f, 0.06f, -0.22f}, 0.115f, kRock);
    add_ball({-0.33f, 0.165f, 0.17f}, 0.125f, kBrain);
    add_ball({0.14f, 0.165f, 0.29f}, 0.072f, kBrain);
    add_ball({0.46f, 0.10f, -0.02f}, 0.10f, kBrain);
}

void Reef::add_tree(glm::vec3 root, std::vector<glm::vec3> targets, float step, float reach, float tip_radius,
                    float exponent, Material material) {
    const Tree tree = colonise(root, std::move(targets), step, reach);
    const std::vector<bool> keep = worth_keeping(tree, 4);
    const size_t count = tree.at.size();

    // A branch is as thick as what it carries (the pipe model: r^e = sum of the children's r^e).
    std::vector<float> pipe(count, 0), to_tip(count, 0);
    std::vector<size_t> heir(count, 0);  // the thickest child, which goes on with the strand
    const float tip = std::pow(tip_radius, exponent);
    for (size_t n = count; n-- > 1;) {
        if (!keep[n]) continue;
        if (pipe[n] == 0) pipe[n] = tip;
        const size_t p = static_cast<size_t>(tree.parent[n]);
        if (heir[p] == 0 || pipe[n] > pipe[heir[p]]) heir[p] = n;
        pipe[p] += pipe[n];
        to_tip[p] = std::max(to_tip[p], to_tip[n] + step);
    }
    float longest = to_tip[0];
    std::vector<uint32_t> strand(count, new_strand());
    const auto radius = [&](size_t n) { return std::pow(pipe[n], 1 / exponent); };
    const auto age = [&](size_t n) { return 1 - std::sqrt(to_tip[n] / longest); };
    for (size_t n = 1; n < count; ++n) {
        if (!keep[n]) continue;
        const size_t p = static_cast<size_t>(tree.parent[n]);
        strand[n] = heir[p] == n ? strand[p] : new_strand();
        // A side branch starts as thin as it is, not as thick as the trunk that it leaves.
        const float from = heir[p] == n ? radius(p) : radius(n);
        add(tree.at[p], tree.at[n], from, radius(n), age(p), age(n), strand[n], material);
    }
}

void Reef::add_branching_coral() {
    Random random(4);
    std::vector<glm::vec3> targets;
    while (targets.size() < 900) {
        const glm::vec3 p = random.in_ball();
        // A crown with a hollow underside, so that trunk and limbs show.
        if (p.y < -0.25f || glm::length(p - glm::vec3(0, -0.80f, 0)) < 0.85f) continue;
        targets.push_back(glm::vec3(0.02f, 0.60f, -0.03f) + p * glm::vec3(0.44f, 0.40f, 0.38f));
    }
    add_tree({0.0f, 0.14f, -0.02f}, std::move(targets), 0.015f, 0.038f, 0.0095f, 2.6f, kBranch);
}

void Reef::add_fan(glm::vec3 root, float turn, float size, uint64_t seed) {
    Random random(seed);
    const glm::vec3 across(std::cos(turn), 0, std::sin(turn)), through(-std::sin(turn), 0, std::cos(turn));
    std::vector<glm::vec3> targets;
    while (targets.size() < 3000) {
        const float x = random.within(-0.55f, 0.55f), y = random.within(0.12f, 1.0f);
        const float half_width =
            0.52f * std::sqrt(std::max(0.0f, std::sin(y * 3.0f))) * (1 + 0.12f * std::sin(9 * y));
        if (std::abs(x) > half_width) continue;
        // Bent like a sail.
        const float bend = 0.35f * x * x + 0.10f * y * y + 0.02f * std::sin(7 * x);
        targets.push_back(root + size * (across * x + glm::vec3(0, y, 0) + through * bend));
    }
    add_tree(root, std::move(targets), 0.011f * size, 0.0155f * size, 0.0027f, 3.4f, kFan);
}

void Reef::add_anemone(glm::vec3 centre, uint64_t seed) {
    Random random(seed);
    add(centre - glm::vec3(0, 0.07f, 0), centre, 0.05f, 0.042f, 0, 0, new_strand(), kAnemone);
    constexpr int kTentacles = 64, kJoints = 18;
    for (int i = 0; i < kTentacles; ++i) {
        const uint32_t strand = new_strand();
        const float out = std::sqrt((static_cast<float>(i) + 0.5f) / kTentacles);
        const float turn = 2.39996323f * static_cast<float>(i);  // the golden angle spreads them evenly
        const glm::vec3 side(std::cos(turn), 0, std::sin(turn));
        glm::vec3 at = centre + 0.036f * out * side;
        glm::vec3 heading = glm::normalize(glm::vec3(0, 1.2f - out, 0) + 1.1f * out * side);
        const float step = random.within(0.0058f, 0.0082f);
        const glm::vec3 sway = 0.30f * random.in_ball();
        for (int j = 0; j < kJoints; ++j) {
            const float age_a = static_cast<float>(j) / kJoints, age_b = static_cast<float>(j + 1) / kJoints;
            const auto radius = [](float age) {
                return 0.0062f - 0.0032f * age + 0.0022f * smooth_step(0.85f, 1.0f, age);
            };
            const glm::vec3 curl = sway * std::sin(5 * age_a) + 0.16f * random.in_ball() +
                                   glm::vec3(0, 0.14f, 0) * (age_a - 0.25f);
            heading = glm::normalize(heading + curl);
            add(at, at + step * heading, radius(age_a), radius(age_b), age_a, age_b, strand, kAnemone);
            at += step * heading;
        }
    }
}

void Reef::add_urchin(glm::vec3 centre, float radius, uint64_t seed) {
    Random random(seed);
    add_ball(centre, radius, kUrchin);
    constexpr int kSpines = 170;
    for (int i = 0; i < kSpines; ++i) {
        const float y = 1 - (2 * static_cast<float>(i) + 1) / kSpines;
        const float turn = 2.39996323f * static_cast<float>(i), flat = std::sqrt(1 - y * y);
        const glm::vec3 way = glm::normalize(glm::vec3(flat * std::cos(turn), y, flat * std::sin(turn)) +
                                             0.12f * random.in_ball());
        add(centre + 0.8f * radius * way, centre + radius * random.within(2.3f, 3.6f) * way, 0.0042f, 0.0018f,
            0, 1, new_strand(), kUrchin);
    }
}

Reef::List Reef::all() const {
    List list(segments_.size());
    std::iota(list.begin(), list.end(), 0);
    return list;
}

// Segments that are nearest or reach to melt with the nearest; the blend of strands is
//     d = min - k/3 * ln(sum of (1 - (d_i - min) / k_i)^3),
// which, unlike a chain of pairwise minima, takes no notice at all of what is out of reach and of the
// order: leaving segments out by narrow() changes no bit on either side of a block's face.
Reef::Blend Reef::blend(const List& list, glm::vec3 p) const {
    struct Near {
        Hit hit;
        Material material;
    };
    thread_local std::vector<Near> strands;
    strands.clear();
    float nearest = 1e9f;
    uint32_t strand = UINT32_MAX;
    for (const uint32_t index : list) {
        const Segment& s = segments_[index];
        const Hit hit = measure(s, p);
        nearest = std::min(nearest, hit.distance);
        if (s.strand != strand)
            strands.push_back({hit, s.material});
        else if (hit.distance < strands.back().hit.distance)
            strands.back().hit = hit;
        strand = s.strand;
    }
    Blend result;
    float sum = 0, reach = 0;
    for (const Near& near : strands) {
        const float k = melt(near.hit.radius), u = 1 - (near.hit.distance - nearest) / k;
        if (!(u > 0)) continue;
        const float w = u * u * u;
        sum += w;
        reach += w * k;
        result.weight[near.material] += w;
        result.age[near.material] += w * near.hit.age;
    }
    if (sum == 0) return {1e9f, {}, {}};
    for (int m = 0; m < kMaterials; ++m) {
        if (result.weight[m] > 0) result.age[m] /= result.weight[m];
        result.weight[m] /= sum;
    }
    result.distance = nearest - reach / sum / 3 * std::log(sum);
    return result;
}

bool Reef::narrow(const List& list, glm::vec3 centre, float radius, List& near) const {
    near.clear();
    thread_local std::vector<float> distances;
    distances.clear();
    float nearest = 1e9f;
    for (const uint32_t index : list) {
        distances.push_back(measure(segments_[index], centre).distance);
        nearest = std::min(nearest, distances.back());
    }
    const float slack = 2 * kSegmentSteepness * radius;
    for (size_t i = 0; i < list.size(); ++i) {
        const Segment& s = segments_[list[i]];
        if (distances[i] <= nearest + slack + melt(std::max(s.radius_a, s.radius_b))) near.push_back(list[i]);
    }
    const float distance = std::max(blend(near, centre).distance, -centre.y);
    return std::abs(distance) <= kSteepness * radius + kMaxRelief;
}

float Reef::field(const List& list, glm::vec3 p) const {
    const Blend at = blend(list, p);
    float distance = at.distance;
    // Beyond twice its strength the relief can change no sign next to the surface, and it costs most.
    if (std::abs(distance) < 2 * kMaxRelief)
        for (uint8_t m = 0; m < kMaterials; ++m)
            if (at.weight[m] > 0) distance -= at.weight[m] * relief(static_cast<Material>(m), at.age[m], p);
    return std::max(distance, -p.y);  // it stands on the ground
}

glm::u8vec3 Reef::colour(const List& list, glm::vec3 p) const {
    const Blend at = blend(list, p);
    Colour sum(0);
    for (uint8_t m = 0; m < kMaterials; ++m)
        if (at.weight[m] > 0) sum += at.weight[m] * colour_of(static_cast<Material>(m), at.age[m], p);
    return glm::u8vec3(glm::clamp(sum, 0.0f, 1.0f) * 255.0f + 0.5f);
}

}  // namespace coral
