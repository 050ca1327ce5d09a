// What the client holds: the octree as the server has it, what is drawn of it, and what is to go.
//
// Ge et al. 2006, sections 5.2 and 5.3.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "ppve/client/reconstruction.h"
#include "ppve/messages.h"
#include "ppve/octree.h"

namespace ppve {

// One thread.
class PointCache {
  public:
    explicit PointCache(const TreeShape& shape);

    struct Taken {
        bool is_in_step;
        uint64_t samples_kept, points_removed;
    };
    // Does what the answer says, and decimates what is new.  Throws core::Error where its bytes are wrong.
    Taken take_in(const Answer& answer, double time_s);

    // The model as it is now; shares with earlier ones what has not changed.
    std::shared_ptr<const PointModel> model() const { return model_; }

    // Clusters of a model (by its numbers) were drawn.
    void note_drawn(const PointModel& model, const std::vector<uint8_t>& seen, double time_s);
    // What is to be deleted: what was not drawn for keep_s, and beyond most_bytes what was not drawn for
    // longest, with room for an update like the largest.
    std::vector<ClusterId> obsolete(double time_s, double keep_s, uint64_t most_bytes) const;

    const Octree& tree() const { return tree_; }
    uint64_t bytes() const { return tree_.bytes() + level_bytes_; }
    uint64_t last_answer() const { return last_answer_; }

  private:
    struct Entry {
        std::shared_ptr<const DrawnCluster> drawn;
        uint64_t bytes = 0;
        double used_s = 0;
    };
    void rebuild(double time_s);

    Octree tree_;
    uint64_t last_answer_ = 0;
    std::unordered_map<ClusterId, Entry> entries_;
    std::shared_ptr<const PointModel> model_;
    uint64_t level_bytes_ = 0, largest_update_ = 0;
};

}  // namespace ppve
