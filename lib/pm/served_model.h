// A model as a server hands it out, and what it keeps of a client: which splits it has sent.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pm/model.h"
#include "pm/replica.h"
#include "pm/service.h"
#include "pm/split_code.h"

namespace pm {

// Shared by all clients; does not change.
class ServedModel {
  public:
    // Throws core::Error where its base mesh is none.
    explicit ServedModel(Model model);

    const Model& model() const { return model_; }
    // encode_base() of the base mesh, with its vertices in the order of a walk over its faces.
    std::span<const std::byte> base_packet(Service service = Service::selective) const {
        return tells_bounds(service) ? base_packet_ : bare_base_packet_;
    }
    // By base vertex of the packet: that of the model.
    std::span<const uint32_t> base_order() const { return base_order_; }
    Replica base_replica(Service service = Service::selective) const;

    VertexData vertex_data(uint32_t vertex) const;
    ChildData child_data(uint32_t split_by) const;  // of the node that a detail splits; kNone: a leaf

  private:
    void order_base();

    Model model_;
    std::vector<uint32_t> base_order_;
    BaseMesh base_;
    std::vector<std::byte> base_packet_, bare_base_packet_;
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
    size_t memory_bytes() const;
    size_t bits_bytes() const { return bits_.size() * sizeof(uint64_t); }

    // Details that were found to need another one that was not wanted, and the detail that the client takes
    // it for.
    struct Blocked {
        uint32_t detail, needs;
    };
    std::span<const Blocked> blocked() const { return blocked_; }
    // In the place of what was told of this detail before.
    void block(uint32_t detail, uint32_t needs);

    Service service;
    // Details whose cones were sent, in any order.
    std::vector<uint32_t> cones;
    SplitModels models;

  private:
    std::vector<Blocked> blocked_;
    std::vector<uint64_t> bits_;
    uint32_t count_ = 0;
};

// The client's replica, as the server has it: with the model's names of nodes and vertices.
class ServedReplica {
  public:
    // From nothing but the record.  Throws core::Error where the model's cut vertices do not fit together.
    ServedReplica(const ServedModel& served, const SentRecord& record);

    const Replica& replica() const { return replica_; }
    Replica& replica() { return replica_; }
    uint32_t detail_of(uint32_t node) const { return detail_[node]; }

    // The split of a node whose detail may be sent, in its ring.
    SplitData split_data(const SentRecord& record, uint32_t node, const Ring& ring) const;
    // The positions of its cut vertices now, which may be equal.
    Cuts cuts(const SentRecord& record, uint32_t node, const Ring& ring) const;
    void apply(uint32_t node, const SplitData& split, const Ring& ring);

    size_t memory_bytes() const;

  private:
    int position_of(const SentRecord& record, uint32_t leaf, const Ring& ring) const;

    const ServedModel& served_;
    Replica replica_;
    std::vector<uint32_t> detail_;      // by node: the model's detail that splits it
    std::vector<uint32_t> model_name_;  // by vertex
};

// The record of a client that comes back: which nodes of its replica are split and whose cones it knows, node
// by node in the order of the tree.
std::vector<std::byte> encode_record(const Replica& replica);
// Throws core::Error where it is none of this model.
SentRecord decode_record(const ServedModel& served, std::span<const std::byte> bytes,
                         Service service = Service::selective);

}  // namespace pm
