#include "pm/model.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/parallel.h"

namespace pm {

namespace {

template <class T>
T load(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    return value;
}

bool are_missing(const glm::u32vec3& corners) {
    return corners == glm::u32vec3(kNone);
}

// The numbers of one model, looked at one by one.  Each returns what is wrong, or null.
struct ContentChecks {
    const Header& h;
    Hierarchy tree;
    std::span<const uint32_t> root_split;
    std::span<const Children> children;

    bool are_vertices(const glm::u32vec3& v) const {
        return glm::all(glm::lessThan(v, glm::u32vec3(uint32_t(h.vertices()))));
    }

    bool is_child(uint32_t detail, uint32_t of, uint32_t kept) const {
        return detail == kNone ||
               (detail < h.details && tree.parent[detail] == of && tree.kept[detail] == kept);
    }

    const char* fault_of_place(uint32_t d) const {
        const uint32_t kept = tree.kept[d], parent = tree.parent[d];
        if (parent == kNone) {
            if (kept >= h.base_vertices || root_split[kept] != d)
                return "splits a root that does not know it";
            return nullptr;
        }
        if (parent >= d) return "has a parent that is not before it";
        const bool is_kept = kept == tree.kept[parent] && children[parent].kept == d;
        const bool is_fresh = kept == tree.born_by(parent) && children[parent].fresh == d;
        return is_kept || is_fresh ? nullptr : "splits a node that its parent did not make";
    }

    const char* fault_of(uint32_t d) const {
        if (const char* fault = fault_of_place(d)) return fault;
        if (tree.needs[d] != kNone && tree.needs[d] >= d) return "needs a detail that is not before it";
        if (!is_child(children[d].kept, d, tree.kept[d]) || !is_child(children[d].fresh, d, tree.born_by(d)))
            return "has a child that does not know it";
        const SplitFaces& faces = tree.faces[d];
        const bool has_left = !are_missing(faces.left), has_right = !are_missing(faces.right);
        if (!has_left && !has_right) return "adds no face";
        if ((has_left && !are_vertices(faces.left)) || (has_right && !are_vertices(faces.right)))
            return "adds a face with a corner that is not there";
        return nullptr;
    }
};

}  // namespace

Model::Model(const std::string& path) : Model(core::InputFile(path)) {}

Model::Model(core::InputFile file)
    : file_(std::move(file)), header_(parse_header(file_.bytes(), file_.name())), layout_(header_) {
    const auto number = [](uint64_t n) { return static_cast<unsigned long long>(n); };
    const uint64_t size = file_.bytes().size();
    if (size < layout_.end)
        throw core::Error(core::text("%s: cut off at byte %llu of %llu", name().c_str(), number(size),
                                     number(layout_.end)));
    if (size > layout_.end)
        throw core::Error(
            core::text("%s: %llu bytes behind its end", name().c_str(), number(size - layout_.end)));
    check_contents();
    weld_numbers_ = WeldNumbers(welds(), [this](uint32_t vertex) { return exact_position(vertex); });
}

template <class T>
std::span<const T> Model::section(uint64_t offset, uint64_t count) const {
    // Sections start at multiples of 8 bytes of a map, or of memory that was allocated.
    return {reinterpret_cast<const T*>(at(offset)), count};
}

bool Model::is_padding_zero() const {
    const uint64_t v = header_.vertices(), n = header_.details;
    const auto is_zero = [&](uint64_t from, uint64_t used, uint64_t to) {
        return std::all_of(at(from + used), at(to), [](std::byte b) { return b == std::byte{0}; });
    };
    const Layout& l = layout_;
    return is_zero(l.base_faces, uint64_t(12) * header_.base_faces, l.root_split) &&
           is_zero(l.root_split, uint64_t(4) * header_.base_vertices, l.kept) &&
           is_zero(l.kept, 4 * n, l.parent) && is_zero(l.parent, 4 * n, l.needs) &&
           is_zero(l.needs, 4 * n, l.children) && is_zero(l.axis, 2 * n, l.angle) &&
           is_zero(l.angle, n, l.error) && is_zero(l.error, n, l.radius) &&
           is_zero(l.radius, n, l.positions) &&
           is_zero(l.positions, header_.position_bytes() * v, l.normals) &&
           is_zero(l.normals, header_.has_normals() ? 2 * v : 0, l.colours) &&
           is_zero(l.colours, header_.has_colours() ? 3 * v : 0, l.welds);
}

Hierarchy Model::hierarchy() const {
    Hierarchy h;
    h.base_vertices = header_.base_vertices;
    h.base_faces = section<glm::u32vec3>(layout_.base_faces, header_.base_faces);
    h.kept = section<uint32_t>(layout_.kept, header_.details);
    h.parent = section<uint32_t>(layout_.parent, header_.details);
    h.needs = section<uint32_t>(layout_.needs, header_.details);
    h.faces = section<SplitFaces>(layout_.faces, header_.details);
    return h;
}

std::span<const uint32_t> Model::root_split() const {
    return section<uint32_t>(layout_.root_split, header_.base_vertices);
}
std::span<const Children> Model::children() const {
    return section<Children>(layout_.children, header_.details);
}
std::span<const Weld> Model::welds() const {
    return section<Weld>(layout_.welds, header_.welds);
}

ConeCodes Model::cone(uint32_t detail) const {
    return {load<uint16_t>(at(layout_.axis) + uint64_t(2) * detail), uint8_t(at(layout_.angle)[detail])};
}

NodeBounds Model::bounds(uint32_t detail) const {
    const auto kept = load<uint32_t>(at(layout_.kept) + uint64_t(4) * detail);
    return {unit(kept), error_code(detail), radius_code(detail), cone(detail)};
}

glm::u32vec3 Model::lattice(uint32_t vertex) const {
    const std::byte* p = at(layout_.positions) + uint64_t(header_.position_bytes()) * vertex;
    if (header_.position_bytes() == 12) return load<glm::u32vec3>(p);
    return glm::u32vec3(load<glm::u16vec3>(p));
}

glm::vec3 Model::single(uint32_t vertex) const {
    return load<glm::vec3>(at(layout_.positions) + uint64_t(12) * vertex);
}

glm::dvec3 Model::unit(uint32_t vertex) const {
    return header_.is_lossless() ? unit_from_single(single(vertex), header_)
                                 : unit_from_lattice(lattice(vertex), header_);
}

glm::dvec3 Model::world(uint32_t vertex) const {
    // Not by way of unit space, which would round.
    if (header_.is_lossless()) return header_.placement.origin + glm::dvec3(single(vertex));
    return header_.placement.world_from_unit(unit(vertex));
}

glm::u8vec3 Model::colour(uint32_t vertex) const {
    return load<glm::u8vec3>(at(layout_.colours) + uint64_t(3) * vertex);
}

uint16_t Model::normal_code(uint32_t vertex) const {
    return load<uint16_t>(at(layout_.normals) + uint64_t(2) * vertex);
}

glm::u32vec3 Model::exact_position(uint32_t vertex) const {
    if (!header_.is_lossless()) return lattice(vertex);
    return load<glm::u32vec3>(at(layout_.positions) + uint64_t(12) * vertex);
}

void Model::check_contents() const {
    const ContentChecks checks{header_, hierarchy(), root_split(), children()};
    const auto codes_fault = [&](uint32_t d) -> const char* {
        if (d > 0 && error_code(d) > error_code(d - 1)) return "has a larger error than the one before it";
        const ConeCodes codes = cone(d);
        const bool are_codes =
            radius_code(d) <= kMaxRadiusCode && codes.axis < kAxisCodes && codes.angle <= kAnyDirection;
        return are_codes ? nullptr : "has a bound that is not in its range";
    };
    const auto vertex_fault = [&](uint32_t v) -> const char* {
        if (header_.is_lossless()) {
            const glm::vec3 p = single(v);
            return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) ? nullptr : "is not finite";
        }
        const auto last = uint32_t(header_.steps());
        return glm::all(glm::lessThanEqual(lattice(v), glm::u32vec3(last))) ? nullptr
                                                                            : "is not on the lattice";
    };
    // The first fault is named, whatever the number of threads.
    const auto check = [&](const char* what, uint64_t count, const auto& fault_of) {
        std::atomic<uint64_t> first{count};
        core::parallel_pieces(count, 1 << 16, [&](size_t begin, size_t end) {
            for (uint64_t i = begin; i < end && i < first; ++i)
                if (fault_of(uint32_t(i)) != nullptr) {
                    for (uint64_t seen = first; i < seen && !first.compare_exchange_weak(seen, i);) {
                    }
                    break;
                }
        });
        if (first < count)
            throw core::Error(core::text("%s: %s %llu %s", name().c_str(), what,
                                         static_cast<unsigned long long>(first), fault_of(uint32_t(first))));
    };
    check("base face", header_.base_faces, [&](uint32_t f) {
        return checks.are_vertices(checks.tree.base_faces[f]) ? nullptr : "has a corner that is not there";
    });
    check("root", header_.base_vertices, [&](uint32_t v) {
        return checks.is_child(checks.root_split[v], kNone, v) ? nullptr
                                                               : "is split by a detail that does not know it";
    });
    check("detail", header_.details, [&](uint32_t d) {
        const char* fault = checks.fault_of(d);
        return fault ? fault : codes_fault(d);
    });
    check("vertex", header_.vertices(), vertex_fault);
    check("weld", header_.welds, [&](uint32_t w) {
        const Weld weld = welds()[w];
        return weld.copy < vertices() && weld.of < vertices() ? nullptr : "names a vertex that is not there";
    });
}

glm::dvec3 unit_from_single(const glm::vec3& position, const Header& header) {
    return (glm::dvec3(position) - header.placement.low) / header.placement.extent;
}

}  // namespace pm
