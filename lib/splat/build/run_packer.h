// Packing triangles into runs (triangle_run.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "splat/triangle_run.h"

namespace splat {

class RunPacker {
  public:
    explicit RunPacker(uint32_t lattice_bits) : lattice_bits_(lattice_bits) {}

    struct Corner {
        uint32_t vertex;  // corners of one vertex share an entry
        glm::ivec3 position;
        uint32_t normal;
    };
    // Not to a full run.  Corners may come back in another order, of the same sense.
    void add(const Corner (&corners)[3], bool is_smooth);
    bool is_empty() const { return triangles_.empty(); }
    bool is_full() const { return triangles_.size() == kMostRunTriangles; }

    // Appends the run's bytes and begins anew.
    void finish(std::vector<std::byte>& out);

  private:
    class Writer;
    // An earlier triangle's edge, the other way round.
    struct Glue {
        static constexpr uint32_t kNone = ~0u;
        uint32_t triangle = kNone, edge = 0;
    };
    // What was met, by what it is: open addressing.
    template <class Value>
    class Met {
      public:
        Value find(uint64_t key) const { return slots_[slot_of(key)].value; }  // as made where it was not met
        Value& operator[](uint64_t key) {
            const size_t slot = slot_of(key);
            if (slots_[slot].key != key) slots_[slot].key = key, used_.push_back(slot);
            return slots_[slot].value;
        }
        void clear() {
            for (const size_t slot : used_) slots_[slot] = {};
            used_.clear();
        }

      private:
        static constexpr int kSlotBits = 11;
        static_assert(3 * kMostRunTriangles < (1 << kSlotBits) / 2);
        struct Slot {
            uint64_t key = ~uint64_t(0);
            Value value{};
        };
        size_t slot_of(uint64_t key) const {
            size_t slot = key * 0x9e3779b97f4a7c15u >> (64 - kSlotBits);
            while (slots_[slot].key != ~uint64_t(0) && slots_[slot].key != key)
                slot = (slot + 1) % slots_.size();
            return slot;
        }
        std::vector<Slot> slots_{size_t(1) << kSlotBits};
        std::vector<size_t> used_;
    };
    struct Entry {
        static constexpr uint32_t kNone = ~0u;
        uint32_t number = kNone;
    };

    Glue find_glue(const Corner (&corners)[3], int& first);
    uint32_t take_entry(const Corner& corner, const Parallelogram& expected);
    void write_triangles(Writer& bits) const;
    glm::i64vec3 off_expected(size_t entry) const;
    glm::ivec2 off_told(size_t entry) const;

    const uint32_t lattice_bits_;
    Met<Entry> entry_of_;  // by vertex
    Met<Glue> glue_of_;    // by entries of a directed edge
    std::vector<int32_t> positions_[3];
    std::vector<uint32_t> normals_, told_normals_;
    std::vector<uint8_t> needs_normal_;    // by entry: a smooth triangle has it
    std::vector<Parallelogram> expected_;  // by entry
    std::vector<glm::u32vec3> triangles_;
    std::vector<Glue> glue_;       // by triangle
    std::vector<uint8_t> smooth_;  // by triangle
};

}  // namespace splat
