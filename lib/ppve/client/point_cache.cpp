#include "ppve/client/point_cache.h"

#include <algorithm>
#include <bit>

#include "core/error.h"
#include "core/parallel.h"
#include "ppve/elimination.h"

namespace ppve {

namespace {

bool is_same(const DrawnCluster& drawn, const Cluster& cluster) {
    return std::equal(drawn.patches.begin(), drawn.patches.end(), cluster.patches.begin(),
                      cluster.patches.end(), [](const auto& a, const auto& b) { return a->patch == b; });
}

// What a cluster is to be drawn as; patches that were there before are taken over.
std::shared_ptr<const DrawnCluster> drawn_of(const Cluster& cluster, const DrawnCluster* before,
                                             double unit) {
    auto drawn = std::make_shared<DrawnCluster>();
    drawn->id = cluster.id;
    for (const auto& patch : cluster.patches) {
        std::shared_ptr<const PatchLevels> levels;
        if (before)
            for (const auto& old : before->patches)
                if (old->patch == patch) levels = old;
        drawn->patches.push_back(levels ? levels : decimate(patch, unit));
    }
    return drawn;
}

uint64_t bytes_of(const DrawnCluster& drawn) {
    uint64_t sum = sizeof drawn;
    for (const auto& levels : drawn.patches) sum += levels->bytes();
    return sum;
}

uint64_t bytes_of(const Cluster& cluster) {
    uint64_t sum = 0;
    for (const auto& patch : cluster.patches) sum += patch->bytes();
    return sum;
}

}  // namespace

PointCache::PointCache(const TreeShape& shape) : tree_(shape), model_(std::make_shared<PointModel>()) {}

PointCache::Taken PointCache::take_in(const Answer& answer, double time_s) {
    const uint64_t before = bytes();
    const DepthImage image = image_of(answer);
    Change change;
    change.starts_anew = answer.starts_anew;
    change.obsolete = answer.deleted;
    change.removed = read_removals(answer.replaced, answer.starts_anew ? 0 : tree_.points());
    change.update = answer.id;
    change.added = &image;
    Taken taken{false, image.samples(), 0};
    for (const Removal& removal : change.removed)
        taken.points_removed += uint64_t(std::count(removal.is_removed.begin(), removal.is_removed.end(), 1));
    tree_.apply(change);
    last_answer_ = answer.id;
    taken.is_in_step = tree_.checksum() == answer.octree_checksum;
    rebuild(time_s);
    if (bytes() > before) largest_update_ = std::max(largest_update_, bytes() - before);
    return taken;
}

void PointCache::rebuild(double time_s) {
    std::vector<const Cluster*> clusters;
    tree_.for_each([&](const Cluster& cluster) { clusters.push_back(&cluster); });
    std::vector<std::shared_ptr<const DrawnCluster>> drawn(clusters.size());
    core::parallel_for(clusters.size(), [&](size_t k) {
        const auto found = entries_.find(clusters[k]->id);
        const DrawnCluster* const before = found == entries_.end() ? nullptr : found->second.drawn.get();
        drawn[k] = before && is_same(*before, *clusters[k])
                       ? found->second.drawn
                       : drawn_of(*clusters[k], before, tree_.shape().unit());
    });
    std::unordered_map<ClusterId, Entry> entries;
    entries.reserve(clusters.size());
    level_bytes_ = 0;
    for (size_t k = 0; k < clusters.size(); ++k) {
        const auto found = entries_.find(clusters[k]->id);
        // One that is new, and such are the parts of one that was cut, counts as drawn.
        const double used_s = found == entries_.end() ? time_s : found->second.used_s;
        const uint64_t bytes = bytes_of(*drawn[k]);
        level_bytes_ += bytes;
        entries[clusters[k]->id] = {drawn[k], bytes + bytes_of(*clusters[k]), used_s};
    }
    entries_ = std::move(entries);
    auto model = std::make_shared<PointModel>();
    model->unit = tree_.shape().unit();
    model->clusters = std::move(drawn);
    model_ = std::move(model);
}

void PointCache::note_drawn(const PointModel& model, const std::vector<uint8_t>& seen, double time_s) {
    for (size_t k = 0; k < seen.size() && k < model.clusters.size(); ++k) {
        if (!seen[k]) continue;
        if (const auto found = entries_.find(model.clusters[k]->id); found != entries_.end())
            found->second.used_s = time_s;
    }
}

std::vector<ClusterId> PointCache::obsolete(double time_s, double keep_s, uint64_t most_bytes) const {
    struct Candidate {
        double used_s;
        ClusterId id;
        uint64_t bytes;
    };
    std::vector<Candidate> candidates;
    for (const auto& [id, entry] : entries_) candidates.push_back({entry.used_s, id, entry.bytes});
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return a.used_s != b.used_s ? a.used_s < b.used_s : a.id < b.id;
    });
    std::vector<ClusterId> ids;
    uint64_t left = bytes();
    const uint64_t aim = most_bytes - std::min(most_bytes / 2, largest_update_);
    for (const Candidate& candidate : candidates) {
        if (!(time_s - candidate.used_s > keep_s) && left <= aim) break;
        if (ids.size() == kMostDeletions) break;
        ids.push_back(candidate.id);
        left -= std::min(left, candidate.bytes);
    }
    return ids;
}

}  // namespace ppve
