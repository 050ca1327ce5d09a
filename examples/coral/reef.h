// A piece of coral reef as a signed distance field: rock, brain corals, a branching coral, two sea
// fans, an anemone and urchins.  It exists to be a hard and handsome model: thin strands and solid
// bodies side by side, relief from a third of the model down to a few thousandths of it, colour.
// The same everywhere: random numbers are our own, with a fixed seed.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace coral {

enum Material : uint8_t { kRock, kBrain, kBranch, kFan, kAnemone, kUrchin, kMaterials };

// A ball swept along a straight line, its radius going linearly from one end to the other.  Segments
// of one strand join with a hard union, strands and bodies melt into each other.
struct Segment {
    glm::vec3 a, ab;
    float inverse_length2;  // of ab; 0 for a ball
    float radius_a, radius_b;
    float age_a, age_b;  // 0 where it grew from, 1 at the tip
    uint32_t strand;
    Material material;
};

// The scene stands on y = 0, y up, inside bound_min()..bound_max(); units are metres, about.
class Reef {
  public:
    using List = std::vector<uint32_t>;  // segments, ascending

    Reef();

    glm::vec3 bound_min() const { return {-0.72f, -0.02f, -0.50f}; }
    glm::vec3 bound_max() const { return {0.62f, 1.04f, 0.54f}; }
    List all() const;

    // Puts into `near` those of `list` that matter for field() within `radius` of `centre`.  False if
    // the surface is nowhere there.
    bool narrow(const List& list, glm::vec3 centre, float radius, List& near) const;

    // Negative inside, positive outside; near the surface a distance within a factor of 3.  `list`
    // from narrow() or all(): the value does not depend on which.
    float field(const List& list, glm::vec3 p) const;

    // The colour at a point of the surface, sRGB.
    glm::u8vec3 colour(const List& list, glm::vec3 p) const;

  private:
    // What meets at a point.  Weights sum to 1.
    struct Blend {
        float distance = 0;
        float weight[kMaterials] = {};
        float age[kMaterials] = {};
    };

    uint32_t new_strand() { return strands_++; }
    void add(glm::vec3 a, glm::vec3 b, float radius_a, float radius_b, float age_a, float age_b,
             uint32_t strand, Material material);
    void add_ball(glm::vec3 centre, float radius, Material material);
    void add_rock();
    void add_tree(glm::vec3 root, std::vector<glm::vec3> targets, float step, float reach, float tip_radius,
                  float exponent, Material material);
    void add_fan(glm::vec3 root, float turn, float size, uint64_t seed);
    void add_branching_coral();
    void add_anemone(glm::vec3 centre, uint64_t seed);
    void add_urchin(glm::vec3 centre, float radius, uint64_t seed);

    Blend blend(const List& list, glm::vec3 p) const;

    std::vector<Segment> segments_;
    uint32_t strands_ = 0;
};

}  // namespace coral
