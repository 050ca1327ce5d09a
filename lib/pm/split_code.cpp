#include "pm/split_code.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "pm/welds.h"

namespace pm {

namespace {

// Where the position of a new vertex is expected, on the lattice, and how far off.
struct Prediction {
    glm::i64vec3 position{0};
    size_t size_class = 0;  // half octaves
    std::array<size_t, 3> axis_class{};
};

size_t half_octaves(uint64_t size) {
    if (size < 2) return size_t(size);
    const size_t length = size_t(std::bit_width(size));
    return 2 * (length - 1) + size_t(size >> (length - 2) & 1);
}

// From the neighbours that the new vertex will have: the one that is split, and those from cut to cut.
Prediction predict(const SplitPlace& place, Cuts cuts) {
    const int count = int(place.ring.size());
    const int begin = cuts.left < 0 ? 0 : cuts.left, end = cuts.right < 0 ? count - 1 : cuts.right;
    const int steps = (end - begin + count) % count;
    const glm::i64vec3 origin(place.vertex.position);
    glm::i64vec3 sum(0);
    glm::dvec3 normal(0), before(0);
    int64_t spread = 0;
    for (int i = 0; i <= steps; ++i) {
        const glm::i64vec3 offset = glm::i64vec3(place.ring[size_t((begin + i) % count)]) - origin;
        sum += offset;
        spread += std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
        if (i > 0) normal += glm::cross(before, glm::dvec3(offset));
        before = glm::dvec3(offset);
    }
    Prediction prediction;
    const int64_t parts = steps + 2;  // the vertex itself is one of its neighbours
    const auto rounded = [&](int64_t value) {
        return (value >= 0 ? value + parts / 2 : value - parts / 2) / parts;
    };
    prediction.position = origin + glm::i64vec3(rounded(sum.x), rounded(sum.y), rounded(sum.z));
    prediction.size_class = half_octaves(uint64_t(spread / parts));
    const double square = glm::dot(normal, normal);
    for (int axis = 0; axis != 3; ++axis) {
        const double share = square > 0 ? normal[axis] * normal[axis] / square : 0.4;
        prediction.axis_class[size_t(axis)] = share < 0.1 ? 0 : share < 0.6 ? 1 : 2;
    }
    return prediction;
}

template <class Coder>
uint32_t code_coordinate(Coder& coder, SplitModels& models, const Prediction& prediction, int axis,
                         uint32_t value, uint32_t most) {
    const size_t size = prediction.size_class;
    const size_t shift = size < kFineClasses + 2 ? 0 : (size - kFineClasses) / 2;
    const size_t of_size = size < kFineClasses + 2 ? size : kFineClasses + size % 2;
    const int64_t residual = int64_t(value) - prediction.position[axis];
    const int64_t high =
        code_signed(coder, models.position[of_size][prediction.axis_class[size_t(axis)]], residual >> shift);
    const uint32_t low = coder.uniform(1u << shift, uint32_t(residual) & ((1u << shift) - 1));
    const int64_t coded = prediction.position[axis] + high * (int64_t(1) << shift) + low;
    if (coded < 0 || coded > int64_t(most)) throw core::Error("split: a position is off the lattice");
    return uint32_t(coded);
}

// Single precision as integers in the order of the numbers.
uint32_t ordered(uint32_t bits) {
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}
uint32_t unordered(uint32_t number) {
    return number & 0x80000000u ? number & 0x7fffffffu : ~number;
}

// The difference goes round, so that it fits.
template <class Coder>
uint32_t code_exact(Coder& coder, SignedModel<32>& model, uint32_t from, uint32_t value) {
    const int32_t difference = int32_t(ordered(value) - ordered(from));
    // -2^31 has no magnitude in 31 bits; no two finite numbers are so far apart.
    const int64_t coded = code_signed(coder, model, difference);
    const uint32_t bits = unordered(ordered(from) + uint32_t(coded));
    if (!std::isfinite(std::bit_cast<float>(bits))) throw core::Error("split: a position is not finite");
    return bits;
}

template <class Coder>
uint16_t code_weld(Coder& coder, BitModel& is_welded, NumberModel<17>& model, uint16_t weld) {
    if (!coder.bit(is_welded, weld != 0)) return 0;
    const uint32_t number = 1 + code_number(coder, model, uint32_t(weld - 1));
    if (number > kMostWeldNumber) throw core::Error("split: the number of a weld is too large");
    return uint16_t(number);
}

template <class Coder>
VertexData code_vertex(Coder& coder, SplitModels& models, const Header& header, const SplitPlace& place,
                       Cuts cuts, const VertexData& value) {
    const VertexData& from = place.vertex;
    VertexData coded;
    if (header.is_lossless()) {
        for (int axis = 0; axis != 3; ++axis)
            coded.position[axis] =
                code_exact(coder, models.exact[size_t(axis)], from.position[axis], value.position[axis]);
    } else {
        const Prediction prediction = predict(place, cuts);
        const uint32_t most = (uint32_t(1) << header.bits) - 1;
        for (int axis = 0; axis != 3; ++axis)
            coded.position[axis] =
                code_coordinate(coder, models, prediction, axis, value.position[axis], most);
    }
    if (header.has_colours())
        for (int i = 0; i != 3; ++i)
            coded.colour[i] = uint8_t(from.colour[i] + code_signed(coder, models.colour[size_t(i)],
                                                                   value.colour[i] - from.colour[i]));
    if (header.has_normals() && coder.bit(models.normal_is_known, value.normal != 0xffff)) {
        uint16_t normal = 0;
        for (int half = 0; half != 2; ++half) {
            const int base = from.normal >> (8 * half) & 0xff, given = value.normal >> (8 * half) & 0xff;
            const int64_t difference = code_signed(coder, models.normal[size_t(half)], given - base);
            normal = uint16_t(normal | (uint32_t(base + difference) & 0xff) << (8 * half));
        }
        coded.normal = normal;
    }
    if (header.welds > 0) {
        const bool is_at_boundary = cuts.left < 0 || cuts.right < 0;
        coded.weld =
            code_weld(coder, models.is_welded[is_at_boundary][from.weld != 0], models.weld, value.weld);
    }
    return coded;
}

template <class Coder>
ChildData code_child(Coder& coder, SplitModels& models, const SplitPlace& of, const ChildData* kept,
                     const ChildData& value) {
    ChildData coded;
    const size_t leaf_class = !kept ? 0 : kept->is_leaf ? 1 : 2;
    coded.is_leaf = coder.bit(models.leaf[of.error * kErrorClasses / 256][leaf_class], value.is_leaf);
    if (coded.is_leaf) return coded;
    if (!value.is_leaf && value.error > of.error) throw core::Error("model: an error is above its parent's");
    const size_t error_class = !kept ? 0 : !kept->is_leaf && of.error - kept->error < 6 ? 1 : 2;
    const uint32_t drop = code_number(coder, models.error[error_class], uint32_t(of.error - value.error));
    if (drop > of.error) throw core::Error("split: an error is below the lattice");
    coded.error = uint8_t(of.error - drop);
    const size_t radius_class = (kept ? 6 : 0) + std::min<size_t>(drop / 2, 5);
    const int64_t radius =
        of.radius - code_signed(coder, models.radius[radius_class], of.radius - value.radius);
    if (radius < 0 || radius > kMaxRadiusCode) throw core::Error("split: a radius is off the lattice");
    coded.radius = uint8_t(radius);
    return coded;
}

// Which cut vertices there are, and where.
template <class Coder>
Cuts code_split_cuts(Coder& coder, SplitModels& models, const SplitPlace& place, Cuts cuts) {
    const uint32_t count = uint32_t(place.ring.size());
    if (count < 2) throw core::Error("split: its vertex has no ring");
    const bool has_left = place.is_closed || !coder.bit(models.missing[0], cuts.left < 0);
    const bool has_right = place.is_closed || !has_left || !coder.bit(models.missing[1], cuts.right < 0);
    Cuts coded;
    if (has_left) coded.left = int(coder.uniform(std::min(count, 65536u), uint32_t(cuts.left)));
    if (!has_right) return coded;
    if (!has_left) {
        coded.right = int(coder.uniform(std::min(count, 65536u), uint32_t(cuts.right)));
        return coded;
    }
    const uint32_t span = uint32_t(cuts.right - cuts.left + int(count)) % count;  // 1 .. count - 1
    const uint32_t coded_span = 1 + (count <= 16 ? code_tree(coder, models.span[count], span - 1)
                                                 : code_number(coder, models.long_span, span - 1));
    if (coded_span >= count) throw core::Error("split: its cut vertices are not in the ring");
    coded.right = int((uint32_t(coded.left) + coded_span) % count);
    return coded;
}

}  // namespace

template <class Coder>
SplitData code_split(Coder& coder, SplitModels& models, const Header& header, bool tells_bounds,
                     const SplitPlace& place, const SplitData& split) {
    SplitData coded;
    coded.cuts = code_split_cuts(coder, models, place, split.cuts);
    coded.vertex = code_vertex(coder, models, header, place, coded.cuts, split.vertex);
    if (!tells_bounds) return coded;
    coded.kept = code_child(coder, models, place, nullptr, split.kept);
    coded.fresh = code_child(coder, models, place, &coded.kept, split.fresh);
    return coded;
}

template <class Coder>
Cuts code_cuts(Coder& coder, size_t ring_size, Cuts cuts) {
    const uint32_t count = uint32_t(std::min<size_t>(ring_size, 65536));
    if (count == 0) throw core::Error("split: its vertex has no ring");
    const int left = int(coder.uniform(count, uint32_t(cuts.left)));
    return {left, int(coder.uniform(count, uint32_t(cuts.right)))};
}

template SplitData code_split(RangeEncoder&, SplitModels&, const Header&, bool, const SplitPlace&,
                              const SplitData&);
template SplitData code_split(RangeDecoder&, SplitModels&, const Header&, bool, const SplitPlace&,
                              const SplitData&);
template Cuts code_cuts(RangeEncoder&, size_t, Cuts);
template Cuts code_cuts(RangeDecoder&, size_t, Cuts);

// ---- the base mesh ----

namespace {

struct BaseModels {
    NumberModel<> first, second, third;
    std::array<SignedModel<32>, 3> position;
    std::array<SignedModel<10>, 3> colour;
    TreeModel<8> normal_high, normal_low, error;
    TreeModel<6> radius;
    BitModel leaf, is_welded;
    NumberModel<17> weld;
};

// Faces by their lowest corner; the others by how far they are beyond it.
template <class Coder>
void code_faces(Coder& coder, BaseModels& models, std::vector<glm::u32vec3>& faces, uint32_t vertices) {
    uint32_t first = 0;
    for (glm::u32vec3& face : faces) {
        const glm::u32vec3 given = face;
        const uint64_t a = uint64_t(first) + code_number(coder, models.first, given.x - first);
        const uint64_t b = a + code_number(coder, models.second, given.y - given.x);
        const uint64_t c = a + code_number(coder, models.third, given.z - given.x);
        if (a >= vertices || b >= vertices || c >= vertices)
            throw core::Error("base mesh: a corner is no vertex");
        face = glm::u32vec3(a, b, c);
        first = uint32_t(a);
    }
}

// By vertex: one of its neighbours that stands before it, or else the vertex before it.
std::vector<uint32_t> earlier_neighbours(const std::vector<glm::u32vec3>& faces, uint32_t vertices) {
    std::vector<uint32_t> earlier(vertices);
    for (uint32_t v = 1; v < vertices; ++v) earlier[v] = v - 1;
    std::vector<bool> is_found(vertices);
    for (const glm::u32vec3& face : faces)
        for (int i = 0; i != 3; ++i)
            for (const uint32_t other : {face[(i + 1) % 3], face[(i + 2) % 3]})
                if (other < face[i] && !is_found[face[i]]) {
                    earlier[face[i]] = other;
                    is_found[face[i]] = true;
                }
    return earlier;
}

template <class Coder>
void code_base_vertex(Coder& coder, BaseModels& models, const Header& header, const VertexData& from,
                      VertexData& vertex) {
    const uint32_t most = header.is_lossless() ? 0 : (uint32_t(1) << header.bits) - 1;
    for (int i = 0; i != 3; ++i) {
        SignedModel<32>& model = models.position[size_t(i)];
        if (header.is_lossless()) {
            vertex.position[i] = code_exact(coder, model, from.position[i], vertex.position[i]);
            continue;
        }
        const int64_t difference = int64_t(vertex.position[i]) - int64_t(from.position[i]);
        const int64_t coded = from.position[i] + code_signed(coder, model, difference);
        if (coded < 0 || coded > int64_t(most)) throw core::Error("base mesh: a position is off the lattice");
        vertex.position[i] = uint32_t(coded);
    }
    if (header.has_colours())
        for (int i = 0; i != 3; ++i)
            vertex.colour[i] = uint8_t(from.colour[i] + code_signed(coder, models.colour[size_t(i)],
                                                                    vertex.colour[i] - from.colour[i]));
    if (header.has_normals()) {
        const uint32_t high = code_tree(coder, models.normal_high, vertex.normal >> 8);
        vertex.normal = uint16_t(high << 8 | code_tree(coder, models.normal_low, vertex.normal & 0xffu));
    }
    if (header.welds > 0) vertex.weld = code_weld(coder, models.is_welded, models.weld, vertex.weld);
}

template <class Coder>
void code_base(Coder& coder, const Header& header, BaseMesh& base) {
    auto models = std::make_unique<BaseModels>();
    const uint32_t vertices = header.base_vertices;
    code_faces(coder, *models, base.faces, vertices);
    const std::vector<uint32_t> earlier = earlier_neighbours(base.faces, vertices);
    for (uint32_t v = 0; v != vertices; ++v) {
        const VertexData from = v == 0 ? VertexData{} : base.vertices[earlier[v]];
        code_base_vertex(coder, *models, header, from, base.vertices[v]);
        if (base.nodes.empty()) continue;
        ChildData& node = base.nodes[v];
        node.is_leaf = coder.bit(models->leaf, node.is_leaf);
        if (node.is_leaf) continue;
        node.error = uint8_t(code_tree(coder, models->error, node.error));
        node.radius = uint8_t(code_tree(coder, models->radius, node.radius));
    }
}

}  // namespace

std::vector<std::byte> encode_base(const Header& header, const BaseMesh& base) {
    RangeEncoder encoder;
    BaseMesh copy = base;
    code_base(encoder, header, copy);
    return encoder.finish();
}

BaseMesh decode_base(const Header& header, std::span<const std::byte> bytes, bool has_bounds) {
    // Each face and each vertex takes a bit at least... of a coder that can give much for little; so the
    // counts are bounded by the caller (client.h).
    BaseMesh base;
    base.vertices.resize(header.base_vertices);
    base.faces.resize(header.base_faces);
    if (has_bounds) base.nodes.resize(header.base_vertices);
    RangeDecoder decoder(bytes);
    code_base(decoder, header, base);
    if (decoder.is_beyond_end()) throw core::Error("base mesh: it is cut off");
    return base;
}

}  // namespace pm
