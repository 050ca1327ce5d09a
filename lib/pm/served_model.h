// A model as a server hands it out, and what it keeps of a client: which splits it has sent.
#pragma once

#include <bit>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pm/face_index.h"
#include "pm/model.h"
#include "pm/replica.h"
#include "pm/service.h"
#include "pm/split_code.h"

namespace pm {

// Shared by all clients; does not change.
class ServedModel {
  public:
    // Throws core::Error where its base mesh is none, or it is too large.
    explicit ServedModel(Model model);

    const Model& model() const { return model_; }
    // encode_base() of the base mesh, with its vertices in the order of a walk over its faces.
    std::span<const std::byte> base_packet(Service service = Service::selective) const {
        return tells_bounds(service) ? base_packet_ : bare_base_packet_;
    }
    // By base vertex of the packet: that of the model.
    std::span<const uint32_t> base_order() const { return base_order_; }
    const FaceIndex& faces() const { return faces_; }

    // Those of the model, but together in memory: views look at a hundred times as many nodes as they split.
    NodeBounds bounds(uint32_t detail) const {
        const Bounds& b = bounds_[detail];
        return {unit_from_exact(b.position, model_.header()), b.error, b.radius, {b.axis, b.angle}};
    }

    VertexData vertex_data(uint32_t vertex) const;
    ChildData child_data(uint32_t split_by) const;  // of the node that a detail splits; kNone: a leaf

  private:
    struct Bounds {
        glm::u32vec3 position;
        uint8_t error, radius;
        uint16_t axis;
        uint8_t angle;
    };
    void order_base();

    Model model_;
    std::vector<Bounds> bounds_;  // by detail
    std::vector<uint32_t> base_order_;
    BaseMesh base_;
    std::vector<std::byte> base_packet_, bare_base_packet_;
    FaceIndex faces_;
};

// What a server remembers of a client: a bit a detail, up to the last one that was sent, and the few things
// beside splits that it has told.  Details stand in the order of falling error, so views that are coarse take
// little.
class SentRecord {
  public:
    explicit SentRecord(Service of = Service::selective) : service(of) {}

    bool is_sent(uint32_t detail) const {
        return detail / 64 < bits_.size() && (bits_[detail / 64] >> (detail % 64) & 1) != 0;
    }
    void add(uint32_t detail) {
        if (detail / 64 >= bits_.size()) bits_.resize(detail / 64 + 1);
        bits_[detail / 64] |= uint64_t{1} << (detail % 64);
        ++count_;
    }
    uint32_t count() const { return count_; }
    uint32_t end() const { return uint32_t(bits_.size() * 64); }  // what was sent has smaller numbers
    // The details that were sent, rising.
    template <class Use>
    void for_each(const Use& use) const {
        for (size_t i = 0; i != bits_.size(); ++i)
            for (uint64_t left = bits_[i]; left != 0; left &= left - 1)
                use(uint32_t(64 * i + size_t(std::countr_zero(left))));
    }
    size_t memory_bytes() const;
    size_t bits_bytes() const { return bits_.size() * sizeof(uint64_t); }

    // Of a detail that was found to need another one that was not wanted: the node that the client takes it
    // to wait for; kNone: it was told nothing.
    uint32_t waits_for(uint32_t detail) const {
        if (waiting_.empty()) return kNone;
        const auto found = waiting_.find(detail);
        return found == waiting_.end() ? kNone : found->second;
    }
    void wait_for(uint32_t detail, uint32_t needs) { waiting_[detail] = needs; }

    Service service;
    // Details whose cones were sent, in any order.
    std::vector<uint32_t> cones;
    SplitModels models;

  private:
    std::map<uint32_t, uint32_t> waiting_;
    std::vector<uint64_t> bits_;
    uint32_t count_ = 0;
};

// The record of a client that comes back: which nodes of its replica are split and whose cones it knows, node
// by node in the order of the tree.
std::vector<std::byte> encode_record(const Replica& replica);
// Throws core::Error where it is none of this model.
SentRecord decode_record(const ServedModel& served, std::span<const std::byte> bytes,
                         Service service = Service::selective);

}  // namespace pm
