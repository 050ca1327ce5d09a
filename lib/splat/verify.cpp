#include "splat/verify.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <vector>

#include "core/error.h"
#include "splat/triangle_reader.h"
#include "splat/triangle_sizes.h"
#include "splat/walk.h"

namespace splat {

namespace {

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

void check_header(const core::InputFile& file) {
    const Header h = parse_header(file.bytes(), file.name());
    const auto refuse = [&](const std::string& what) {
        throw core::Error(file.name() + ": header: " + what);
    };
    constexpr uint32_t kKnown = kHasColour | kConstantColour | kOpenSurface | kCloud | kTriangles;
    if (h.flags & ~kKnown) refuse(core::text("unknown flags %08x", h.flags & ~kKnown));
    if ((h.flags & kCloud) && !(h.flags & kOpenSurface)) refuse("bare points as a closed surface");
    if ((h.flags & kCloud) && h.triangles_in > 0)
        refuse(core::text("bare points with %llu triangles", number(h.triangles_in)));
    if (h.has_triangles() && h.leaf_count > h.triangles_in)
        refuse(core::text("%llu leaves of %llu triangles", number(h.leaf_count), number(h.triangles_in)));
    if (!h.has_triangles() && h.leaf_count > h.vertices_in)
        refuse(core::text("%llu leaves of %llu vertices", number(h.leaf_count), number(h.vertices_in)));
    const auto canonical = encode_header(h);
    const auto plain = is_coded(file.bytes()) ? file.bytes().subspan(kCodedHeaderSize) : file.bytes();
    const auto differs = std::mismatch(canonical.begin(), canonical.end(), plain.begin()).first;
    if (differs != canonical.end())
        refuse(core::text("byte %d is reserved and not 0", int(differs - canonical.begin())));
}

// What a block says without its nodes being decoded.
class BlockChecks {
  public:
    explicit BlockChecks(const Model& model) : model_(model), queued_(model.layout().capacity) {
        queued_.place(model.header().root_children);
    }

    void run() {
        for (uint64_t b = 0; b < model_.node_blocks_present(); ++b) {
            view_.open(model_, b);
            check_unused(b);
            check_pointer(b);
        }
        if (!model_.is_complete()) return;  // the next group is not known
        for (const Pointer& p : unsettled_) settle(p, {p.block, 0});
    }

  private:
    // A block and where it says that the next child group is.
    struct Pointer {
        uint64_t block;
        GroupAt to;
    };

    void check_unused(uint64_t b) {
        const std::span<const std::byte> bytes = model_.block(b);
        const BlockLayout& layout = model_.layout();
        const uint32_t nodes = view_.node_count();
        const auto zero = [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                if (bytes[i] != std::byte{0}) model_.fault(b, core::text("unused byte %zu is not 0", i));
        };
        const size_t pair = 2 * size_t(nodes);
        zero(layout.attitude + pair, layout.place);
        zero(layout.place + pair, layout.colour);
        if (view_.colour()) zero(layout.colour + pair, layout.shape);
        if ((nodes & 1) && view_.shape_of(nodes) != 0)
            model_.fault(b, core::text("unused half of byte %zu is not 0", layout.shape + nodes / 2));
        zero(layout.shape + (nodes + 1) / 2, bytes.size());
    }

    // A block points to the next child group in order, be it its own or that of a later block.
    void check_pointer(uint64_t b) {
        BlockHeader head;
        std::memcpy(&head, model_.block(b).data(), sizeof(head));
        unsettled_.push_back({b, {head.child_block, head.child_slot}});
        for (uint32_t slot = 0; slot < view_.node_count(); ++slot) {
            if (view_.children_of(slot) == 0) continue;
            const GroupAt at = queued_.place(uint32_t(view_.children_of(slot)));
            for (const Pointer& p : unsettled_) settle(p, at);
            unsettled_.clear();
        }
    }

    void settle(const Pointer& p, const GroupAt& expected) const {
        if (p.to != expected)
            model_.fault(p.block,
                         core::text("points to block %llu slot %u, the next group is at block %llu slot %u",
                                    number(p.to.block), p.to.slot, number(expected.block), expected.slot));
    }

    const Model& model_;
    GroupCursor queued_;
    BlockView view_;
    std::vector<Pointer> unsettled_;
};

// Runs of triangles, and that they follow each other.
class RunChecks {
  public:
    explicit RunChecks(const Model& model) : model_(model) {}

    void run() {
        BlockView nodes;
        BlockTriangles triangles;
        for (uint64_t b = 0; b < model_.node_blocks_present(); ++b) {
            nodes.open(model_, b);
            triangles.open(model_, nodes);
            check_begin(b, nodes.triangles_at(), triangles.leaf_count() > 0 ? at_ : 0);
            for (const BlockTriangles::PlacedRun& placed : triangles.runs()) {
                at_ = placed.at + placed.run.size_bytes();
                take_sizes(placed.run);
            }
            check_middle(b, nodes.middle_side());
        }
        if (model_.is_complete()) check_end();
    }

  private:
    // Known as long as all runs before are there.
    void check_begin(uint64_t node_block, uint64_t at, uint64_t expected) const {
        const Header& h = model_.header();
        if (at == expected || h.node_blocks() + at_ / h.triangle_payload() >= model_.blocks_present()) return;
        model_.fault(
            node_block,
            core::text("its triangles are at byte %llu of all runs, the order puts them at byte %llu",
                       number(at), number(expected)));
    }

    void take_sizes(const TriangleRun& run) {
        for (uint32_t t = 0; t < run.triangles(); ++t) {
            const glm::u32vec3& e = run.entries(t);
            sizes_.add(run.position(e.x), run.position(e.y), run.position(e.z));
        }
    }

    void check_middle(uint64_t node_block, float side) {
        const float expected =
            sizes_.empty() ? 0 : sizes_.take_middle(std::ldexp(1.0, -int(model_.header().lattice_bits)));
        if (side != expected && model_.is_complete())
            model_.fault(node_block,
                         core::text("its middle triangle's longest side is %.9g, its header says %.9g",
                                    double(expected), double(side)));
    }

    void check_end() const {
        const Header& h = model_.header();
        const uint64_t payload = h.triangle_payload(), last = h.block_count - 1;
        if (at_ + payload <= h.triangle_blocks * payload) model_.fault(last, "runs of no leaves");
        const auto bytes = model_.triangle_block(last);
        for (size_t i = bytes.size() - (h.triangle_blocks * payload - at_); i < bytes.size(); ++i)
            if (bytes[i] != std::byte{0}) model_.fault(last, core::text("unused byte %zu is not 0", i));
    }

    const Model& model_;
    uint64_t at_ = 0;  // where the next run is
    TriangleSizes sizes_;
};

// Normals within `index`'s half-angle of `axis`; index -1: none.
struct Cone {
    glm::vec3 axis{0, 0, 1};
    int index = -1;
};

bool cones_meet(const Cone& a, const Cone& b) {
    constexpr double kTolerance = 1e-5;  // radians: single precision of two decoded normals
    const glm::dvec3 p(a.axis), q(b.axis);
    const double between = std::atan2(glm::length(glm::cross(p, q)), glm::dot(p, q));
    const auto half = [](int index) { return double(std::acos(kConeCos[index])); };
    return between <= half(a.index) + half(b.index) + kTolerance;
}

class NodeChecks {
  public:
    explicit NodeChecks(const Model& model) : model_(model) {
        const Node root = model.root();
        cones_.push_back({{root.normal, root.cone}, root.children});
    }

    VerifyCounts run() {
        walk(model_, kMaxLevels, [&](const WalkedNode& n) { check(n); });
        counts_.blocks = model_.blocks_present();
        return counts_;
    }

  private:
    void check(const WalkedNode& n) {
        const auto fault = [&](const std::string& what) {
            model_.fault(n.at.block, core::text("slot %u: ", n.at.slot) + what);
        };
        ++counts_.nodes;
        counts_.levels = n.level;
        const Node& node = n.node;
        if (!(node.radius > 0)) fault("its radius is 0");
        const double reach =
            glm::length(node.centre - n.parent.centre) + (1.0 + double(kSlack)) * double(node.radius);
        const double room = (1.0 + double(kSlack)) * double(n.parent.radius);
        if (!(reach <= room * (1 + 1e-5) + kCentreRounding))
            fault(core::text("its culling sphere reaches %.9g from its parent's centre, which has %.9g",
                             reach, room));
        check_cone(n);
        if (node.children > 0) return;
        ++counts_.leaves;
        if (model_.header().has_triangles()) check_triangle(n);
    }

    // The leaf's ellipsoid covers it.
    void check_triangle(const WalkedNode& n) {
        constexpr double kOutside = 1 + 1e-5;  // single precision of the radius
        if (!triangles_.is_open() || triangles_.number() != n.at.block) {
            block_.open(model_, n.at.block);
            triangles_.open(model_, block_);
        }
        const BlockTriangles::Place at = triangles_.find(n.at.slot);
        if (at.run == BlockTriangles::Place::kNone) return;
        ++counts_.triangles;
        const TriangleRun& run = triangles_.runs()[at.run].run;
        const glm::u32vec3 entries = run.entries(at.triangle);
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 corner =
                glm::dvec3(run.position(entries[k])) * std::ldexp(1.0, -int(model_.header().lattice_bits));
            const glm::dvec3 off = corner - n.node.centre;
            const double along = glm::dot(off, glm::dvec3(n.node.normal)),
                         radius = double(n.node.radius) * kOutside + kCentreRounding;
            const double flat = double(n.node.flatness);
            const double square = glm::dot(off, off) - along * along + along * along / (flat * flat);
            if (!(square <= radius * radius))
                model_.fault(
                    n.at.block,
                    core::text("slot %u: its triangle sticks out of its ellipsoid by a factor of %.6g",
                               n.at.slot, std::sqrt(square) / radius));
        }
    }

    void check_cone(const WalkedNode& n) {
        Inherited& above = cones_.front();
        Cone cone{n.node.normal, n.node.cone};
        if (cone.index >= 0 && above.cone.index >= 0 && !cones_meet(cone, above.cone))
            model_.fault(
                n.at.block,
                core::text("slot %u: its normal cone lies outside that of the node above", n.at.slot));
        if (cone.index < 0) cone = above.cone;
        if (--above.children_left == 0) cones_.pop_front();
        if (n.node.children > 0 && !n.lacks_children) cones_.push_back({cone, n.node.children});
    }

    // Centres are sums in double precision, in a model of radius 1.
    static constexpr double kCentreRounding = 1e-15;

    // The nearest cone at or above a node, for its children.
    struct Inherited {
        Cone cone;
        int children_left;
    };

    const Model& model_;
    VerifyCounts counts_;
    BlockView block_;
    BlockTriangles triangles_;
    std::deque<Inherited> cones_;  // of the groups to come, in the walk's order
};

void check_counts(const Model& model, const VerifyCounts& found) {
    const Header& h = model.header();
    const auto compare = [&](const char* what, uint64_t is, uint64_t said) {
        if (is != said)
            throw core::Error(core::text("%s: %llu %s, its header says %llu", model.name().c_str(),
                                         number(is), what, number(said)));
    };
    compare("nodes", found.nodes, h.node_count);
    compare("leaves", found.leaves, h.leaf_count);
    compare("levels", found.levels, h.level_count);
}

// Codes that no builder writes.
void check_codes(const Model& model) {
    BlockView view;
    const auto check = [&](uint64_t b, uint32_t slot, const char* what, int code, int count) {
        if (code >= count)
            model.fault(b, core::text("slot %u: %s code %d, the last is %d", slot, what, code, count - 1));
    };
    for (uint64_t b = 0; b < model.node_blocks_present(); ++b) {
        view.open(model, b);
        for (uint32_t slot = 0; slot < view.node_count(); ++slot) {
            check(b, slot, "normal", view.attitude()[slot] >> 5 & 1023, kNormalSteps * kNormalSteps);
            check(b, slot, "centre", view.place()[slot] >> 4 & 127, kAcrossSteps * kAcrossSteps);
        }
    }
}

}  // namespace

VerifyCounts verify(core::InputFile file) {
    check_header(file);
    const Model model(std::move(file));
    BlockChecks(model).run();
    if (model.header().has_triangles()) RunChecks(model).run();
    check_codes(model);
    const VerifyCounts counts = NodeChecks(model).run();
    if (!model.is_complete()) {
        const uint64_t blocks = model.header().block_count;
        throw core::Error(core::text("%s: cut off at byte %zu: %llu of %llu blocks are there, without fault",
                                     model.name().c_str(), model.size_bytes(), number(counts.blocks),
                                     number(blocks)));
    }
    check_counts(model, counts);
    return counts;
}

}  // namespace splat
