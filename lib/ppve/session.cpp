#include "ppve/session.h"

#include <algorithm>

#include "core/error.h"
#include "core/stopwatch.h"

namespace ppve {

namespace {

constexpr size_t kMostChecksums = 256;           // answers that a client may be behind
constexpr size_t kMostWantedDeleted = 1u << 20;  // leaves; more are none of a tree's

}  // namespace

Session::Session(Sampler& sampler, const std::string& scene, const SessionLimits& limits)
    : sampler_(sampler),
      scene_(scene),
      limits_(limits),
      bounds_(sampler.bounds()),
      tree_(shape_around(bounds_)) {}

Welcome Session::welcome() const {
    return {.bounds = bounds_,
            .most_pixels = limits_.most_pixels,
            .most_points = limits_.most_points,
            .scene = scene_,
            .sampler = sampler_.name()};
}

void Session::want_deleted(std::span<const uint64_t> leaves) {
    const size_t room = kMostWantedDeleted - wanted_deleted_.size();
    wanted_deleted_.insert(wanted_deleted_.end(), leaves.begin(),
                           leaves.begin() + ptrdiff_t(std::min(room, leaves.size())));
}

std::vector<Refusal> Session::take(Message&& message) {
    if (const auto* deletions = std::get_if<Deletions>(&message)) {
        want_deleted(deletions->leaves);
        return {};
    }
    auto* request = std::get_if<Request>(&message);
    if (request == nullptr) throw core::Error("a client sent what only a server says");
    want_deleted(request->deletions);
    if (is_out_of_step(*request)) is_behind_ = true;
    if (request->id <= last_id_)
        return {{request->id, core::text("requests are counted up; the last one was %llu",
                                         static_cast<unsigned long long>(last_id_))}};
    last_id_ = request->id;
    const uint64_t pixels = uint64_t(request->frustum.view.width) * uint64_t(request->frustum.view.height);
    if (pixels > limits_.most_pixels)
        return {{request->id, core::text("%llu pixels; this server samples %llu at most",
                                         static_cast<unsigned long long>(pixels),
                                         static_cast<unsigned long long>(limits_.most_pixels))}};
    std::vector<Refusal> refusals;
    if (request_) refusals.push_back({request_->id, "a newer request has come"});
    request_ = std::move(*request);
    return refusals;
}

// A client that names an answer from before the tree was started anew will learn of that.
bool Session::is_out_of_step(const Request& request) {
    if (request.last_answer == 0 || request.last_answer < anew_id_) return false;
    const auto found = checksums_.find(request.last_answer);
    if (found == checksums_.end()) return true;
    const bool differs = found->second != request.octree_checksum;
    checksums_.erase(checksums_.begin(), found);
    return differs;
}

std::vector<ClusterId> Session::take_deletions() {
    std::sort(wanted_deleted_.begin(), wanted_deleted_.end());
    wanted_deleted_.erase(std::unique(wanted_deleted_.begin(), wanted_deleted_.end()), wanted_deleted_.end());
    std::vector<ClusterId> leaves, later;
    for (const ClusterId id : wanted_deleted_)
        if (tree_.find(id) != nullptr) (leaves.size() < kMostDeletions ? leaves : later).push_back(id);
    wanted_deleted_ = std::move(later);
    return leaves;
}

// The clusters to be let go so that there is room for `coming` points, `most` of them.  Small patches take
// more for a point than kPointBytes, so that memory is counted beside points.
std::vector<ClusterId> Session::evict(uint64_t coming, size_t most) const {
    const uint64_t room = limits_.most_points > coming ? limits_.most_points - coming : 0;
    uint64_t points = tree_.points(), bytes = tree_.bytes();
    const auto fits = [&] { return points <= room && bytes <= room * kPointBytes; };
    if (fits()) return {};
    struct Candidate {
        uint64_t newest;
        const Cluster* cluster;
    };
    std::vector<Candidate> candidates;
    tree_.for_each([&](const Cluster& c) {
        candidates.push_back({c.patches.back()->sampling().update, &c});
    });
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return a.newest != b.newest ? a.newest < b.newest : a.cluster->id < b.cluster->id;
    });
    std::vector<ClusterId> leaves;
    for (const Candidate& c : candidates) {
        if (fits() || leaves.size() == most) break;
        leaves.push_back(c.cluster->id);
        points -= c.cluster->points(), bytes -= c.cluster->bytes();
    }
    return leaves;
}

Answer Session::make_answer(const Request& request, AnswerReport& report) {
    core::Stopwatch watch;
    Answer answer;
    answer.id = request.id, answer.stamp = request.stamp, answer.starts_anew = is_behind_;
    DepthImage image;
    image.frustum = request.frustum, image.footprint_px = request.footprint_px;
    prepare(sampler_, request.bound_px, image);
    report.sampling = sampler_.sample(image, request.wants_normals);
    report.sample_ms = watch.lap_ms();

    // Nothing can fail on this side from here on but memory: the tree changes as the client's will.
    if (is_behind_) {
        tree_.apply({.starts_anew = true, .obsolete = {}, .removed = {}});
        checksums_.clear(), wanted_deleted_.clear();
        is_behind_ = false, anew_id_ = request.id;
    }
    answer.deleted = take_deletions();
    report.deleted = answer.deleted.size();
    tree_.apply({.obsolete = answer.deleted, .removed = {}});
    const std::vector<ClusterId> evicted = evict(image.samples(), kMostDeletions - answer.deleted.size());
    report.evicted = evicted.size();
    tree_.apply({.obsolete = evicted, .removed = {}});
    answer.deleted.insert(answer.deleted.end(), evicted.begin(), evicted.end());
    const Eliminated eliminated =
        eliminate(tree_, {.kind = request.elimination, .epsilon = request.epsilon}, image);
    report.elimination = eliminated.counts;
    report.eliminate_ms = watch.lap_ms();

    if (!eliminated.removed.empty()) answer.replaced = write_removals(eliminated.removed);
    answer.frustum = image.frustum, answer.coding = image.coding, answer.footprint_px = image.footprint_px;
    answer.has_normals = request.wants_normals, answer.codec = request.codec;
    answer.image = encode(image, request.codec);
    report.encode_ms = watch.lap_ms();

    tree_.apply({.obsolete = {}, .removed = eliminated.removed, .update = request.id, .added = &image});
    answer.octree_checksum = tree_.checksum();
    if (checksums_.size() == kMostChecksums) checksums_.erase(checksums_.begin());
    checksums_[request.id] = answer.octree_checksum;
    report.insert_ms = watch.lap_ms();
    return answer;
}

std::vector<std::byte> Session::answer(AnswerReport& report) {
    core::Stopwatch watch;
    const Request request = std::move(*request_);
    request_.reset();
    report = {};
    report.id = request.id;
    try {
        Answer answer = make_answer(request, report);
        answer.samples = report.elimination.samples, answer.samples_kept = report.elimination.kept;
        answer.counts = report.sampling;
        answer.sample_ms = float(report.sample_ms), answer.encode_ms = float(report.encode_ms);
        answer.eliminate_ms = float(report.eliminate_ms + report.insert_ms);
        report.mantissa_bits = answer.coding.bits;
        report.bound_px = bound_px(answer.coding, answer.frustum.view.focal_px);
        report.image_bytes = answer.image.size();
        report.starts_anew = answer.starts_anew;
        report.tree_points = tree_.points(), report.tree_clusters = tree_.clusters(),
        report.tree_bytes = tree_.bytes();
        std::vector<std::byte> bytes = format(answer);
        report.message_bytes = bytes.size(), report.total_ms = watch.lap_ms();
        return bytes;
    } catch (const core::Error& error) {
        // What the client holds is what was there before, or it will say otherwise.
        is_behind_ = true, report.is_refused = true;
        std::vector<std::byte> bytes = format(Refusal{request.id, error.what()});
        report.message_bytes = bytes.size(), report.total_ms = watch.lap_ms();
        return bytes;
    }
}

}  // namespace ppve
