#include "mesh/qsplat.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>

#include "core/error.h"

namespace mesh {

namespace {

uint32_t big_endian(std::span<const std::byte> bytes, size_t at, int size) {
    uint32_t value = 0;
    for (int k = 0; k < size; ++k) value = value << 8 | uint32_t(bytes[at + size_t(k)]);
    return value;
}

float big_endian_float(std::span<const std::byte> bytes, size_t at) {
    return std::bit_cast<float>(big_endian(bytes, at, 4));
}

// A component of a normal across its face's axis, of 52 steps evenly spread over the angle.
double normal_step(uint32_t step) {
    return std::tan(((step + 0.5) * 2 / kQsplatNormalSteps - 1) * 0.25 * M_PI);
}

glm::u8vec3 decode_565(uint32_t c) {
    const uint32_t r = c >> 11, g = c >> 5 & 63, b = c & 31;
    return {uint8_t(r << 3 | r >> 2), uint8_t(g << 2 | g >> 4), uint8_t(b << 3 | b >> 2)};
}

// One fragment, from its header on.
class FragmentReader {
  public:
    FragmentReader(const Source& source, size_t begin, size_t number,
                   const std::function<void(const QsplatNode&)>& use)
        : name_(source.name),
          bytes_(source.bytes.subspan(begin)),
          begin_(begin),
          number_(number),
          use_(use) {}

    // Adds it to `file`; returns its length.
    size_t read(QsplatFile& file) {
        if (bytes_.size() < kQsplatCommentHeader) fail(0, "the header is cut off");
        if (std::memcmp(bytes_.data(), kQsplatMagic, 8) != 0)
            fail(0, core::text("begins with %s; only QSplat files of version 11 are read",
                               quoted({reinterpret_cast<const char*>(bytes_.data()), 8}).c_str()));
        const uint32_t length = big_endian(bytes_, 8, 4), options = big_endian(bytes_, 16, 4);
        if (length > bytes_.size())
            fail(8, core::text("its length is %u bytes, and the file ends after %zu: it is cut off", length,
                               bytes_.size()));
        if (options & ~(kQsplatHasColour | kQsplatIsComment))
            fail(16, core::text("unknown options %#x", options));
        const bool is_comment = options & kQsplatIsComment;
        if (length < (is_comment ? kQsplatCommentHeader : kQsplatHeader))
            fail(8, core::text("a length of %u bytes", length));
        bytes_ = bytes_.first(length);
        if (is_comment)
            file.comments.push_back(comment());
        else
            file.fragments.push_back(nodes(options & kQsplatHasColour));
        return length;
    }

  private:
    // A node whose child group is still to come.
    struct Waiting {
        QsplatSphere sphere;
        uint32_t level;  // of the children
        uint8_t children;
        bool has_pointer;
    };

    std::string comment() const {
        const auto text = bytes_.subspan(kQsplatCommentHeader);
        std::string out(reinterpret_cast<const char*>(text.data()), text.size());
        while (!out.empty() && (out.back() == '\0' || out.back() == '\n')) out.pop_back();
        for (char& c : out)
            if ((c < ' ' && c != '\n') || c > '~') c = '?';
        return out;
    }

    QsplatFragment nodes(bool has_colour) {
        fragment_.bytes = bytes_.size();
        fragment_.has_colour = has_colour;
        fragment_.root = {
            {big_endian_float(bytes_, 20), big_endian_float(bytes_, 24), big_endian_float(bytes_, 28)},
            big_endian_float(bytes_, 32)};
        const QsplatSphere& root = fragment_.root;
        if (!std::isfinite(root.centre.x + root.centre.y + root.centre.z) || !(root.radius > 0) ||
            !std::isfinite(root.radius))
            fail(20, "the root's sphere is not finite, or has no size");
        const uint32_t children = big_endian(bytes_, 36, 4);
        if (children < 1 || children > kQsplatFanOut)
            fail(36, core::text("the root has %u children; it must have 1 to %d", children, kQsplatFanOut));
        // Whether the first group has a pointer is not stored.  Without one nothing comes behind it but
        // padding, and with one there is a second group, which is longer.
        const bool has_pointer =
            kQsplatHeader + qsplat_group_bytes(children, false, has_colour) + 4 <= bytes_.size();
        at_ = end_ = kQsplatHeader;
        wait({root, 1, uint8_t(children), has_pointer});
        while (!waiting_.empty()) {
            const Waiting group = waiting_.front();
            waiting_.pop_front();
            read_group(group);
        }
        const size_t left = bytes_.size() - at_;
        if (left > 3) fail(at_, core::text("%zu bytes belong to no node", left));
        const uint32_t leaves = big_endian(bytes_, 12, 4);
        if (leaves != fragment_.leaves)
            fail(12, core::text("it is said to have %u leaves and has %llu", leaves,
                                (unsigned long long)fragment_.leaves));
        return fragment_;
    }

    void wait(const Waiting& group) {
        waiting_.push_back(group);
        end_ += qsplat_group_bytes(group.children, group.has_pointer, fragment_.has_colour);
    }

    void read_group(const Waiting& group) {
        const size_t start = at_, node_bytes = qsplat_node_bytes(fragment_.has_colour);
        if (qsplat_group_bytes(group.children, group.has_pointer, fragment_.has_colour) > bytes_.size() - at_)
            fail(at_, "nodes are missing: the fragment ends before them");
        // In breadth-first order the next group goes behind all that are waited for.
        const size_t first_child_group = end_;
        if (group.has_pointer) {
            const uint32_t pointer = big_endian(bytes_, at_, 4);
            if (pointer != first_child_group - start)
                fail(at_, core::text("a pointer of %u, where %zu is in order", pointer,
                                     first_child_group - start));
            at_ += kQsplatPointer;
            ++fragment_.pointers;
        }
        for (uint32_t k = 0; k < group.children; ++k, at_ += node_bytes) read_node(group);
        if ((end_ != first_child_group) != group.has_pointer)
            fail(start, group.has_pointer ? "a pointer to children, and no node has any"
                                          : "nodes with children and no pointer");
    }

    void read_node(const Waiting& group) {
        const uint32_t place = big_endian(bytes_, at_, 2), attitude = big_endian(bytes_, at_ + 2, 2);
        const QsplatSpheres& spheres = QsplatSpheres::get();
        const uint32_t sphere = place >> kQsplatSphereShift, normal = attitude >> kQsplatNormalShift;
        if (sphere >= spheres.count())
            fail(at_, core::text("sphere code %u; the last is %u", sphere, spheres.count() - 1));
        if (normal >= kQsplatNormals)
            fail(at_ + 2, core::text("normal code %u; the last is %u", normal, kQsplatNormals - 1));
        QsplatNode node{spheres.decode(sphere, group.sphere),
                        decode_qsplat_normal(normal),
                        attitude & 3,
                        glm::u8vec3(255),
                        place & kQsplatChildren,
                        group.level};
        if (node.children) ++node.children;
        if (fragment_.has_colour) node.colour = decode_565(big_endian(bytes_, at_ + 4, 2));
        const bool has_grandchildren = place & kQsplatGrandchildren;
        if (node.children)
            wait({node.sphere, group.level + 1, uint8_t(node.children), has_grandchildren});
        else if (has_grandchildren)
            fail(at_, "a leaf with grandchildren");
        else
            ++fragment_.leaves;
        ++fragment_.nodes;
        use_(node);
    }

    [[noreturn]] void fail(size_t at, const std::string& what) const {
        throw core::Error(core::text("%s: fragment %zu at byte %zu: ", name_.c_str(), number_, begin_ + at) +
                          what);
    }

    const std::string& name_;
    std::span<const std::byte> bytes_;
    const size_t begin_, number_;
    const std::function<void(const QsplatNode&)>& use_;
    QsplatFragment fragment_;
    std::deque<Waiting> waiting_;
    size_t at_ = 0;   // the next group's place
    size_t end_ = 0;  // where the first group will be that nobody waits for yet
};

}  // namespace

QsplatSpheres::QsplatSpheres() : code_of_(size_t(kCells) * kCells * kCells * kCells, kNoCode) {
    constexpr float kCell = 1.0f / kCells;
    for (int size = 1; size <= kCells; ++size)
        for (int x = 0; x <= kCells - size; ++x)
            for (int y = 0; y <= kCells - size; ++y)
                for (int z = 0; z <= kCells - size; ++z) {
                    const QsplatSphere s{glm::vec3(size + 2 * x, size + 2 * y, size + 2 * z) * kCell - 1.0f,
                                         float(size) * kCell};
                    const float reach = 1.0f + std::sqrt(3.0f) * s.radius;
                    if (s.centre.x * s.centre.x + s.centre.y * s.centre.y + s.centre.z * s.centre.z >
                        reach * reach)
                        continue;
                    code_of_[size_t(((size - 1) * kCells + x) * kCells + y) * kCells + size_t(z)] = count();
                    codes_.push_back(s);
                }
}

const QsplatSpheres& QsplatSpheres::get() {
    static const QsplatSpheres spheres;
    return spheres;
}

glm::vec3 decode_qsplat_normal(uint32_t code) {
    constexpr uint32_t kFace = kQsplatNormalSteps * kQsplatNormalSteps;
    const uint32_t face = code / kFace;
    const double u = normal_step(code / kQsplatNormalSteps % kQsplatNormalSteps),
                 v = normal_step(code % kQsplatNormalSteps);
    const double square = 1 - u * u - v * v;
    if (!(square >= 0)) return glm::vec3(0);
    const int axis = int(face / 2);
    glm::dvec3 n;
    n[axis] = face & 1 ? -std::sqrt(square) : std::sqrt(square);
    n[(axis + 1) % 3] = u;
    n[(axis + 2) % 3] = v;
    return glm::vec3(n);
}

uint32_t encode_qsplat_normal(const glm::vec3& normal) {
    const glm::vec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t face = uint32_t(2 * axis) + (normal[axis] < 0 ? 1 : 0);
    const auto step = [&](int across) {
        const double turned = std::atan(double(normal[(axis + across) % 3])) * 4 / M_PI;
        return std::clamp(int((turned + 1) * 0.5 * kQsplatNormalSteps), 1, int(kQsplatNormalSteps) - 2);
    };
    // The steps about it, too: they are rounded across the axis, and some at the rim are no normals.
    const int u = step(1), v = step(2);
    uint32_t best = 0;
    float nearest = -2;
    for (int du = -1; du <= 1; ++du)
        for (int dv = -1; dv <= 1; ++dv) {
            const uint32_t code =
                (face * kQsplatNormalSteps + uint32_t(u + du)) * kQsplatNormalSteps + uint32_t(v + dv);
            const glm::vec3 decoded = decode_qsplat_normal(code);
            const float cosine = decoded == glm::vec3(0) ? -2 : glm::dot(decoded, normal);
            if (cosine > nearest) nearest = cosine, best = code;
        }
    return best;
}

bool is_qsplat(const Source& source) {
    return source.text().starts_with("QSplat");
}

QsplatFile walk_qsplat(const Source& source, const std::function<void(const QsplatNode&)>& use) {
    QsplatFile file;
    size_t number = 0;
    for (size_t at = 0; at < source.bytes.size();) at += FragmentReader(source, at, ++number, use).read(file);
    if (file.fragments.empty()) throw core::Error(source.name + ": holds comments and no model");
    return file;
}

ReadResult read_qsplat(const Source& source, const ReadOptions& options, uint32_t level) {
    ReadResult result;
    result.counts.format = "qsplat 11";
    Mesh& mesh = result.mesh;
    const QsplatFile file = walk_qsplat(source, [&](const QsplatNode& node) {
        if (node.level > level || (node.level < level && node.children)) return;
        if (mesh.positions.size() == std::numeric_limits<uint32_t>::max())
            throw core::Error(source.name + ": has 2^32 leaves; a mesh has less");
        mesh.positions.push_back(node.sphere.centre);
        mesh.radii.push_back(node.sphere.radius);
        mesh.normals.push_back(node.normal);
        mesh.colours.push_back(node.colour);
    });
    bool has_colour = false;
    for (const QsplatFragment& fragment : file.fragments) has_colour |= fragment.has_colour;
    if (!has_colour) mesh.colours = {};
    result.counts.vertices_in = mesh.positions.size();
    settle_bad_vertices(source, options, false, result);
    return result;
}

}  // namespace mesh
