#include "pm/served_model.h"

#include <algorithm>

#include "core/error.h"

namespace pm {

// ---- the model ----

ServedModel::ServedModel(Model model) : model_(std::move(model)) {
    const Header& header = model_.header();
    if (header.depth > 0xfffe)
        throw core::Error(model_.name() + ": it is deeper than 65534 splits, and cannot be served");
    if (uint64_t(header.base_faces) + 2 * uint64_t(header.details) >= kNone)
        throw core::Error(model_.name() + ": it has more than 2^32 faces, and cannot be served");
    order_base();
    base_packet_ = encode_base(header, base_);
    BaseMesh bare = base_;
    bare.nodes.clear();
    bare_base_packet_ = encode_base(header, bare);
    RingMesh(header.base_vertices, base_.faces);  // is it one?
    faces_ = FaceIndex(model_, base_order_);
    bounds_.reserve(model_.details());
    for (uint32_t d = 0; d != model_.details(); ++d) {
        const ConeCodes cone = model_.cone(d);
        bounds_.push_back({model_.exact_position(model_.hierarchy().kept[d]), model_.error_code(d),
                           model_.radius_code(d), cone.axis, cone.angle});
    }
}

namespace {

// Neighbours in turn from the first vertex of each component on, so that the corners of a face have like
// numbers.
std::vector<uint32_t> walk_order(uint32_t vertices, const std::vector<glm::u32vec3>& faces) {
    std::vector<std::vector<uint32_t>> neighbours(vertices);
    for (const glm::u32vec3& face : faces)
        for (int i = 0; i != 3; ++i) {
            neighbours[face[i]].push_back(face[(i + 1) % 3]);
            neighbours[face[i]].push_back(face[(i + 2) % 3]);
        }
    std::vector<uint32_t> order;
    std::vector<bool> is_found(vertices);
    for (uint32_t first = 0; first != vertices; ++first) {
        if (is_found[first]) continue;
        is_found[first] = true;
        order.push_back(first);
        for (size_t at = order.size() - 1; at != order.size(); ++at)
            for (const uint32_t next : neighbours[order[at]])
                if (!is_found[next]) {
                    is_found[next] = true;
                    order.push_back(next);
                }
    }
    return order;
}

}  // namespace

void ServedModel::order_base() {
    const Hierarchy tree = model_.hierarchy();
    const auto root_of = [&](uint32_t vertex) {
        while (vertex >= tree.base_vertices) vertex = tree.kept[vertex - tree.base_vertices];
        return vertex;
    };
    std::vector<glm::u32vec3> faces;
    for (const glm::u32vec3& leaves : tree.base_faces)
        faces.emplace_back(root_of(leaves.x), root_of(leaves.y), root_of(leaves.z));
    base_order_ = walk_order(tree.base_vertices, faces);
    std::vector<uint32_t> place(tree.base_vertices);
    for (uint32_t v = 0; v != base_order_.size(); ++v) place[base_order_[v]] = v;
    for (glm::u32vec3& face : faces) {
        face = glm::u32vec3(place[face.x], place[face.y], place[face.z]);
        while (face.x > face.y || face.x > face.z) face = glm::u32vec3(face.y, face.z, face.x);
    }
    std::sort(faces.begin(), faces.end(), [](const glm::u32vec3& a, const glm::u32vec3& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    });
    base_.faces = std::move(faces);
    for (const uint32_t v : base_order_) {
        base_.vertices.push_back(vertex_data(v));
        base_.nodes.push_back(child_data(model_.root_split()[v]));
    }
}

VertexData ServedModel::vertex_data(uint32_t vertex) const {
    const Header& header = model_.header();
    VertexData data;
    data.position = model_.exact_position(vertex);
    if (header.has_colours()) data.colour = model_.colour(vertex);
    if (header.has_normals()) data.normal = model_.normal_code(vertex);
    if (header.welds > 0) data.weld = model_.weld_number(vertex);
    return data;
}

ChildData ServedModel::child_data(uint32_t split_by) const {
    if (split_by == kNone) return {};
    return {false, model_.error_code(split_by), model_.radius_code(split_by)};
}

// ---- what was sent ----

size_t SentRecord::memory_bytes() const {
    constexpr size_t kBytesOfWaiting = 48;  // a node of the map
    return sizeof *this + bits_.capacity() * sizeof(uint64_t) + cones.capacity() * sizeof(uint32_t) +
           waiting_.size() * kBytesOfWaiting;
}

// ---- records of clients ----

namespace {

struct RecordModels {
    std::array<BitModel, kErrorClasses> split;
    BitModel cone;
};

}  // namespace

std::vector<std::byte> encode_record(const Replica& replica) {
    RecordModels models;
    RangeEncoder encoder;
    std::vector<uint32_t> stack;
    for (uint32_t root = replica.vertex_count() - replica.split_count(); root-- > 0;) stack.push_back(root);
    while (!stack.empty()) {
        const Node& node = replica.node(stack.back());
        stack.pop_back();
        if (node.is_leaf) continue;
        if (replica.has_bounds()) encoder.bit(models.cone, node.has_cone);
        if (!encoder.bit(models.split[node.error * kErrorClasses / 256], node.split != kNone)) continue;
        stack.push_back(node.kept_child + 1);
        stack.push_back(node.kept_child);
    }
    return encoder.finish();
}

SentRecord decode_record(const ServedModel& served, std::span<const std::byte> bytes, Service service) {
    const Model& model = served.model();
    const Hierarchy tree = model.hierarchy();
    const bool has_bounds = tells_bounds(service);
    RecordModels models;
    RangeDecoder decoder(bytes);
    SentRecord record(service);
    std::vector<uint32_t> stack;
    for (size_t v = served.base_order().size(); v-- > 0;)
        stack.push_back(model.root_split()[served.base_order()[v]]);
    while (!stack.empty()) {
        const uint32_t d = stack.back();
        stack.pop_back();
        if (d == kNone && has_bounds) continue;
        if (has_bounds && decoder.bit(models.cone)) record.cones.push_back(d);
        const uint8_t error = has_bounds ? model.error_code(d) : kUnknownNode.error;
        if (!decoder.bit(models.split[error * kErrorClasses / 256])) continue;
        if (d == kNone) throw core::Error("record: it splits what cannot be split");
        record.add(d);
        stack.push_back(model.children()[d].fresh);
        stack.push_back(model.children()[d].kept);
    }
    if (decoder.is_beyond_end()) throw core::Error("record: it is cut off");
    for (uint32_t d = 0; d != model.details(); ++d)
        if (record.is_sent(d) && tree.needs[d] != kNone && !record.is_sent(tree.needs[d]))
            throw core::Error("record: it lacks a split that another one needs");
    return record;
}

}  // namespace pm
