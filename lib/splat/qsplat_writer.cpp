#include "splat/qsplat_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "mesh/qsplat.h"
#include "splat/build/cloud.h"

namespace splat {

namespace {

using mesh::QsplatSphere;
using mesh::QsplatSpheres;

constexpr size_t kPiece = 1024;
constexpr uint64_t kMostBytes = std::numeric_limits<int32_t>::max();
// Children are found by adding up single precision numbers; radii lose some four bits a level.
constexpr double kLeastRadius = 1e-25, kMostRadius = 1e25;
constexpr double kSlack = 1 + 1e-6;  // for the rounding of the root, which nothing corrects

struct Leaf {
    glm::vec3 at;  // from the mesh's origin
    float radius = 0;
    glm::vec3 normal{0};  // unit, or zero: unknown
    float cone = 0;       // half-angle about the normal that holds those of the faces
    glm::u8vec3 colour{255};
};

struct TreeNode {
    uint32_t begin, end;  // leaves
    uint32_t first_child = 0;
    uint8_t children = 0;
    bool has_grandchildren = false;
    uint16_t place = 0, attitude = 0, colour = 0;
    QsplatSphere decoded{};  // from the mesh's origin
};

// Radius of the smallest circle about a triangle.
double circle_about(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    glm::dvec3 sides(glm::length(b - c), glm::length(c - a), glm::length(a - b));
    if (sides.y > sides.x) std::swap(sides.x, sides.y);
    if (sides.z > sides.x) std::swap(sides.x, sides.z);
    if (!(sides.x > 0)) return 0;
    const glm::dvec3 s = sides / sides.x;  // 1e30 to the sixth power would be infinite
    if (s.y * s.y + s.z * s.z <= 1) return 0.5 * sides.x;
    const double twice_area = glm::length(glm::cross((b - a) / sides.x, (c - a) / sides.x));
    return 0.5 * sides.x * s.y * s.z / twice_area;
}

double angle_between(const glm::vec3& a, const glm::vec3& b) {
    return std::acos(std::clamp(double(glm::dot(a, b)), -1.0, 1.0));
}

// The mesh's vertices as leaves: radii, normals and cones of their faces.
class Leaves {
  public:
    explicit Leaves(mesh::Mesh& mesh) : mesh_(mesh) {}

    std::vector<Leaf> make() {
        const size_t n = mesh_.positions.size();
        leaves_.resize(n);
        if (mesh_.is_cloud() && mesh_.radii.empty()) mesh_.radii = estimate_discs(mesh_);
        for (size_t i = 0; i < n; ++i) {
            leaves_[i].at = mesh_.positions[i];
            if (!mesh_.radii.empty()) leaves_[i].radius = mesh_.radii[i];
            if (!mesh_.normals.empty()) leaves_[i].normal = mesh_.normals[i];
            if (!mesh_.colours.empty()) leaves_[i].colour = mesh_.colours[i];
            if (mesh_.is_cloud()) leaves_[i].cone = float(M_PI);  // of unknown sense
        }
        if (!mesh_.is_cloud()) add_faces();
        return std::move(leaves_);
    }

    uint64_t unreferenced = 0;

  private:
    void add_faces() {
        std::vector<uint8_t> is_used(leaves_.size(), 0);
        std::vector<glm::dvec3> sums(leaves_.size(), glm::dvec3(0));
        for (const glm::u32vec3& t : mesh_.triangles) {
            const glm::dvec3 a(leaves_[t.x].at), b(leaves_[t.y].at), c(leaves_[t.z].at);
            const float radius =
                std::nextafter(float(circle_about(a, b, c)), std::numeric_limits<float>::infinity());
            const glm::dvec3 area = glm::cross(b - a, c - a);
            for (int k = 0; k < 3; ++k) {
                is_used[t[k]] = 1;
                sums[t[k]] += area;
                leaves_[t[k]].radius = std::max(leaves_[t[k]].radius, radius);
            }
        }
        for (size_t i = 0; i < leaves_.size(); ++i)
            if (leaves_[i].normal == glm::vec3(0)) leaves_[i].normal = mesh::unit_normal(sums[i]);
        widen_cones();
        drop_unused(is_used);
    }

    void widen_cones() {
        for (const glm::u32vec3& t : mesh_.triangles) {
            const glm::dvec3 a(leaves_[t.x].at), b(leaves_[t.y].at), c(leaves_[t.z].at);
            const glm::vec3 normal = mesh::unit_normal(glm::cross(b - a, c - a));
            if (normal == glm::vec3(0)) continue;
            for (int k = 0; k < 3; ++k) {
                Leaf& leaf = leaves_[t[k]];
                leaf.cone = std::max(leaf.cone, leaf.normal == glm::vec3(0)
                                                    ? float(M_PI)
                                                    : float(angle_between(leaf.normal, normal)));
            }
        }
    }

    void drop_unused(const std::vector<uint8_t>& is_used) {
        size_t kept = 0;
        for (size_t i = 0; i < leaves_.size(); ++i)
            if (is_used[i]) leaves_[kept++] = leaves_[i];
        unreferenced = leaves_.size() - kept;
        leaves_.resize(kept);
    }

    mesh::Mesh& mesh_;
    std::vector<Leaf> leaves_;
};

void check_count(size_t leaves, const std::string& name) {
    if (leaves < 3)
        throw core::Error(
            core::text("%s: has %zu vertices; a QSplat file holds at least 3", name.c_str(), leaves));
}

class QsplatWriter {
  public:
    QsplatWriter(mesh::Mesh& mesh, const std::string& name, QsplatReport& report)
        : origin_(mesh.origin), has_colour_(!mesh.colours.empty()), name_(name), report_(report) {
        Leaves leaves(mesh);
        leaves_ = leaves.make();
        report_.unreferenced = leaves.unreferenced;
        mesh = {};
    }

    void write(core::OutputFile& out) {
        check_count(leaves_.size(), name_);
        make_tree();
        check_size();
        code_root();
        for (size_t level = 0; level + 1 < level_begin_.size(); ++level) code_level(level);
        count();
        put_file(out);
    }

  private:
    // Breadth-first: nodes_[0] is the root, children of a node stand together.
    void make_tree() {
        nodes_.push_back({0, uint32_t(leaves_.size())});
        level_begin_ = {0};
        for (size_t begin = 0, end = 1; begin < end; begin = end, end = nodes_.size()) {
            for (size_t i = begin; i < end; ++i) add_children(i);
            level_begin_.push_back(end);
        }
        level_begin_.pop_back();  // of the level that has no nodes
        level_begin_.push_back(nodes_.size());
        for (TreeNode& node : nodes_)
            for (uint32_t k = 0; k < node.children; ++k)
                node.has_grandchildren |= nodes_[node.first_child + k].children > 0;
    }

    void add_children(size_t i) {
        const uint32_t begin = nodes_[i].begin, end = nodes_[i].end;
        if (end - begin < 2) return;
        uint32_t cuts[mesh::kQsplatFanOut + 1] = {begin};
        int count = 0;
        const uint32_t middle = split(begin, end);
        const auto add = [&](uint32_t to) { cuts[++count] = to; };
        // The original reads no file whose root has no grandchildren.
        const bool is_tiny = i == 0 && end - begin <= uint32_t(mesh::kQsplatFanOut);
        if (middle - begin > 1 && !is_tiny) add(split(begin, middle));
        add(middle);
        if (end - middle > 1 && !is_tiny) add(split(middle, end));
        add(end);
        nodes_[i].first_child = uint32_t(nodes_.size());
        nodes_[i].children = uint8_t(count);
        for (int k = 0; k < count; ++k) nodes_.push_back({cuts[k], cuts[k + 1]});
    }

    // Parts the leaves at the middle of the longest side of their box, or by number where this parts none
    // from the others.  Both parts have some.
    uint32_t split(uint32_t begin, uint32_t end) {
        glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
        for (uint32_t i = begin; i < end; ++i)
            low = glm::min(low, leaves_[i].at), high = glm::max(high, leaves_[i].at);
        const glm::vec3 size = 0.5f * high - 0.5f * low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const float middle = 0.5f * low[axis] + 0.5f * high[axis];
        const auto first = leaves_.begin() + begin, last = leaves_.begin() + end;
        const auto cut =
            std::stable_partition(first, last, [&](const Leaf& leaf) { return leaf.at[axis] < middle; });
        if (cut == first || cut == last) return begin + (end - begin) / 2;
        return uint32_t(cut - leaves_.begin());
    }

    void check_size() {
        uint64_t bytes = mesh::kQsplatHeader;
        for (const TreeNode& n : nodes_)
            if (n.children) bytes += mesh::qsplat_group_bytes(n.children, n.has_grandchildren, has_colour_);
        report_.file_bytes = (bytes + 3) / 4 * 4;
        if (report_.file_bytes > kMostBytes)
            throw core::Error(core::text("%s: would take %llu bytes, and a QSplat file holds at most %llu",
                                         name_.c_str(), (unsigned long long)report_.file_bytes,
                                         (unsigned long long)kMostBytes));
    }

    // About the middle of the box of the leaves' spheres.
    QsplatSphere sphere_about(const TreeNode& node) const {
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        for (uint32_t i = node.begin; i < node.end; ++i) {
            const glm::dvec3 at(leaves_[i].at);
            low = glm::min(low, at - double(leaves_[i].radius)),
            high = glm::max(high, at + double(leaves_[i].radius));
        }
        const glm::vec3 centre(0.5 * low + 0.5 * high);
        return {centre, float(needed_radius(node, centre) * kSlack)};
    }

    double needed_radius(const TreeNode& node, const glm::vec3& centre) const {
        double radius = 0;
        for (uint32_t i = node.begin; i < node.end; ++i)
            radius = std::max(radius, glm::distance(glm::dvec3(leaves_[i].at), glm::dvec3(centre)) +
                                          double(leaves_[i].radius));
        return radius;
    }

    void code_root() {
        TreeNode& root = nodes_[0];
        const QsplatSphere s = sphere_about(root);
        // As the file says it: in world units.
        const glm::vec3 centre(world(s.centre));
        const double radius = needed_radius(root, s.centre) * kSlack;
        double step = 0, leaf_radius = 0;
        for (int k = 0; k < 3; ++k) step = std::max(step, std::fabs(double(centre[k])) + radius);
        step *= std::numeric_limits<float>::epsilon();
        for (const Leaf& leaf : leaves_) leaf_radius += double(leaf.radius) / double(leaves_.size());
        if (!(radius >= kLeastRadius && radius <= kMostRadius))
            throw core::Error(core::text("%s: its radius is %g; a QSplat file's may be from %g to %g",
                                         name_.c_str(), radius, kLeastRadius, kMostRadius));
        if (step > 0.25 * leaf_radius)
            throw core::Error(
                core::text("%s: a QSplat file has single-precision coordinates, here of steps of %g, and "
                           "leaves have radii "
                           "of %g: move the model to the origin",
                           name_.c_str(), step, leaf_radius));
        root.decoded = {centre,
                        float((radius + glm::distance(glm::dvec3(centre), world(s.centre))) * kSlack)};
    }

    void code_level(size_t level) {
        const size_t begin = level_begin_[level], end = level_begin_[level + 1];
        core::parallel_pieces(end - begin, kPiece, [&](size_t first, size_t last) {
            for (size_t i = begin + first; i < begin + last; ++i)
                for (uint32_t k = 0; k < nodes_[i].children; ++k)
                    code(nodes_[nodes_[i].first_child + k], nodes_[i].decoded);
        });
    }

    glm::dvec3 world(const glm::vec3& at) const { return origin_ + glm::dvec3(at); }

    bool holds(const QsplatSphere& sphere, const glm::dvec3& centre, double radius) const {
        return glm::distance(centre, glm::dvec3(sphere.centre)) + radius <= double(sphere.radius);
    }

    // The smallest code whose sphere holds the node's; the last is the parent's own sphere, which holds all
    // leaves.
    uint32_t sphere_code(const QsplatSphere& needed, const QsplatSphere& parent) const {
        const QsplatSpheres& spheres = QsplatSpheres::get();
        constexpr int kCells = QsplatSpheres::kCells;
        const glm::dvec3 centre = world(needed.centre);
        const double cells = kCells * double(needed.radius) / double(parent.radius);
        const glm::dvec3 place = (centre - glm::dvec3(parent.centre)) / double(parent.radius);
        for (int size = std::clamp(int(std::ceil(cells)), 1, kCells); size < kCells; ++size) {
            const glm::dvec3 cell = glm::round((place + 1.0) * (0.5 * kCells) - 0.5 * size);
            const uint32_t code =
                spheres.code(size, glm::ivec3(glm::clamp(cell, 0.0, double(kCells - size))));
            if (code != QsplatSpheres::kNoCode &&
                holds(spheres.decode(code, parent), centre, double(needed.radius)))
                return code;
        }
        return spheres.code(kCells, {0, 0, 0});
    }

    void code(TreeNode& node, const QsplatSphere& parent) const {
        const QsplatSphere needed = sphere_about(node);
        const uint32_t sphere = sphere_code(needed, parent);
        node.decoded = QsplatSpheres::get().decode(sphere, parent);
        node.place = uint16_t(sphere << mesh::kQsplatSphereShift |
                              (node.has_grandchildren ? mesh::kQsplatGrandchildren : 0) |
                              (node.children ? node.children - 1 : 0));
        glm::dvec3 sum(0), colour(0);
        for (uint32_t i = node.begin; i < node.end; ++i)
            sum += glm::dvec3(leaves_[i].normal), colour += glm::dvec3(leaves_[i].colour);
        const uint32_t normal = mesh::encode_qsplat_normal(mesh::unit_normal(sum));
        node.attitude = uint16_t(normal << mesh::kQsplatNormalShift |
                                 cone_code(node, mesh::decode_qsplat_normal(normal)));
        const glm::dvec3 mean = colour / double(node.end - node.begin) / 255.0;
        node.colour = uint16_t(std::lround(mean.x * 31) << 11 | std::lround(mean.y * 63) << 5 |
                               std::lround(mean.z * 31));
    }

    // The narrowest that holds the cones of all leaves.
    uint32_t cone_code(const TreeNode& node, const glm::vec3& axis) const {
        constexpr uint32_t kAny = 3;
        const double widest = std::asin(double(mesh::decode_qsplat_cone(kAny - 1)));
        double angle = 0;
        for (uint32_t i = node.begin; i < node.end && angle <= widest; ++i)
            angle = std::max(angle, leaves_[i].normal == glm::vec3(0)
                                        ? M_PI
                                        : angle_between(axis, leaves_[i].normal) + double(leaves_[i].cone));
        uint32_t code = 0;
        while (code < kAny && angle > std::asin(double(mesh::decode_qsplat_cone(code)))) ++code;
        return code;
    }

    void count() {
        double sum = 0;
        uint64_t counted = 0;
        for (const TreeNode& node : nodes_) {
            if (node.children) continue;
            const double needed = double(leaves_[node.begin].radius);
            if (!(needed > 0)) continue;
            const double inflation = double(node.decoded.radius) / needed;
            sum += inflation, ++counted;
            report_.leaf_inflation_max = std::max(report_.leaf_inflation_max, inflation);
        }
        report_.leaf_inflation_mean = counted ? sum / double(counted) : 0;
        report_.leaves = leaves_.size();
        report_.nodes = nodes_.size() - 1;
        report_.levels = level_begin_.size() - 2;
    }

    static void put(std::string& out, uint32_t value, int size = 4) {
        for (int k = size - 1; k >= 0; --k) out += char(value >> (8 * k) & 255);
    }

    void put_file(core::OutputFile& out) {
        std::string bytes = mesh::kQsplatMagic;
        put(bytes, uint32_t(report_.file_bytes));
        put(bytes, uint32_t(leaves_.size()));
        put(bytes, has_colour_ ? mesh::kQsplatHasColour : 0);
        const QsplatSphere& root = nodes_[0].decoded;
        for (const float f : {root.centre.x, root.centre.y, root.centre.z, root.radius})
            put(bytes, std::bit_cast<uint32_t>(f));
        put(bytes, nodes_[0].children);
        uint64_t at = bytes.size(), end = at + group_bytes(nodes_[0]);
        for (const TreeNode& node : nodes_) {
            if (!node.children) continue;
            if (node.has_grandchildren) put(bytes, uint32_t(end - at));
            at += group_bytes(node);
            for (uint32_t k = 0; k < node.children; ++k) end += put_node(bytes, nodes_[node.first_child + k]);
            if (bytes.size() < kBufferBytes) continue;
            out.write(bytes);
            bytes.clear();
        }
        bytes.resize(bytes.size() + (report_.file_bytes - at), '\0');
        out.write(bytes);
    }

    uint64_t group_bytes(const TreeNode& node) const {
        return mesh::qsplat_group_bytes(node.children, node.has_grandchildren, has_colour_);
    }

    // Returns the bytes of its group of children.
    uint64_t put_node(std::string& bytes, const TreeNode& node) const {
        put(bytes, node.place, 2);
        put(bytes, node.attitude, 2);
        if (has_colour_) put(bytes, node.colour, 2);
        return node.children ? group_bytes(node) : 0;
    }

    static constexpr size_t kBufferBytes = size_t(1) << 20;

    const glm::dvec3 origin_;
    const bool has_colour_;
    const std::string& name_;
    QsplatReport& report_;
    std::vector<Leaf> leaves_;
    std::vector<TreeNode> nodes_;
    std::vector<size_t> level_begin_;
};

}  // namespace

QsplatReport write_qsplat(mesh::Mesh&& mesh, const std::string& name, core::OutputFile& out) {
    check_count(mesh.positions.size(), name);
    QsplatReport report;
    QsplatWriter(mesh, name, report).write(out);
    return report;
}

}  // namespace splat
