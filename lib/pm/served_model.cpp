#include "pm/served_model.h"

#include <algorithm>

#include "core/error.h"

namespace pm {

// ---- the model ----

ServedModel::ServedModel(Model model) : model_(std::move(model)) {
    const Header& header = model_.header();
    if (header.depth > 0xfffe)
        throw core::Error(model_.name() + ": it is deeper than 65534 splits, and cannot be served");
    order_base();
    base_packet_ = encode_base(header, base_);
    BaseMesh bare = base_;
    bare.nodes.clear();
    bare_base_packet_ = encode_base(header, bare);
    base_replica();  // is its base mesh one?
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

Replica ServedModel::base_replica(Service service) const {
    return Replica(
        model_.header(), base_.vertices, base_.faces,
        tells_bounds(service) ? std::span<const ChildData>(base_.nodes) : std::span<const ChildData>());
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

void SentRecord::block(uint32_t detail, uint32_t needs) {
    std::erase_if(blocked_, [&](const Blocked& b) { return b.detail == detail; });
    if (needs != kNone) blocked_.push_back({detail, needs});
}

size_t SentRecord::memory_bytes() const {
    return sizeof *this + bits_.capacity() * sizeof(uint64_t) + cones.capacity() * sizeof(uint32_t) +
           blocked_.capacity() * sizeof(Blocked);
}

// ---- the replica ----

ServedReplica::ServedReplica(const ServedModel& served, const SentRecord& record)
    : served_(served), replica_(served.base_replica(record.service)) {
    const Model& model = served.model();
    for (const uint32_t v : served.base_order()) {
        detail_.push_back(model.root_split()[v]);
        model_name_.push_back(v);
    }
    // Nodes by the details that split them: what a detail depends on stands before it.
    std::vector<uint32_t> node_of(model.details(), kNone);
    const auto name_nodes = [&](uint32_t from) {
        for (uint32_t n = from; n != detail_.size(); ++n)
            if (detail_[n] != kNone) node_of[detail_[n]] = n;
    };
    name_nodes(0);
    // The cuts of an earlier detail are looked for among those that are applied already.
    SentRecord applied(record.service);
    Ring ring;
    for (uint32_t d = 0; d != model.details(); ++d) {
        if (!record.is_sent(d)) continue;
        const uint32_t node = node_of[d];
        if (node == kNone) throw core::Error("record: a split has no parent");
        replica_.find_ring(replica_.node(node).vertex, ring);
        const SplitData data = split_data(applied, node, ring);
        const uint32_t children = uint32_t(detail_.size());
        apply(node, data, ring);
        name_nodes(children);
        applied.add(d);
    }
    for (const uint32_t d : record.cones)
        if (node_of[d] != kNone) replica_.learn_cone(node_of[d], model.cone(d));
    for (const SentRecord::Blocked& b : record.blocked())
        if (node_of[b.detail] != kNone && !record.is_sent(b.detail))
            replica_.set_needs(node_of[b.detail], node_of[b.needs]);
}

int ServedReplica::position_of(const SentRecord& record, uint32_t leaf, const Ring& ring) const {
    if (leaf == kNone) return -1;
    const Hierarchy tree = served_.model().hierarchy();
    while (leaf >= tree.base_vertices && !record.is_sent(leaf - tree.base_vertices))
        leaf = tree.kept[leaf - tree.base_vertices];
    for (size_t i = 0; i != ring.neighbours.size(); ++i)
        if (model_name_[ring.neighbours[i]] == leaf) return int(i);
    throw core::Error(served_.model().name() +
                      ": a cut vertex is not in its ring; 'qs-info --verify' says more");
}

Cuts ServedReplica::cuts(const SentRecord& record, uint32_t node, const Ring& ring) const {
    const SplitFaces& faces = served_.model().hierarchy().faces[detail_[node]];
    return {position_of(record, faces.left_cut(), ring), position_of(record, faces.right_cut(), ring)};
}

SplitData ServedReplica::split_data(const SentRecord& record, uint32_t node, const Ring& ring) const {
    const Model& model = served_.model();
    const uint32_t d = detail_[node];
    const Cuts at = cuts(record, node, ring);
    SplitData data;
    data.left = at.left, data.right = at.right;
    data.vertex = served_.vertex_data(model.hierarchy().born_by(d));
    data.kept = served_.child_data(model.children()[d].kept);
    data.fresh = served_.child_data(model.children()[d].fresh);
    return data;
}

void ServedReplica::apply(uint32_t node, const SplitData& split, const Ring& ring) {
    const uint32_t d = detail_[node];
    replica_.apply(node, split, ring);
    detail_.push_back(served_.model().children()[d].kept);
    detail_.push_back(served_.model().children()[d].fresh);
    model_name_.push_back(served_.model().hierarchy().born_by(d));
}

size_t ServedReplica::memory_bytes() const {
    return replica_.memory_bytes() + (detail_.size() + model_name_.size()) * sizeof(uint32_t);
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
