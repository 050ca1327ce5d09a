// The server's half of one client's session: what is to be sampled next, what the client holds, and the
// answers.
//
// A request that comes while another one waits takes its place (the eye has moved on), and the one before is
// refused. All that the client asked to be deleted is deleted by the next answer, whichever that is.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ppve/elimination.h"
#include "ppve/messages.h"
#include "ppve/octree.h"
#include "ppve/sampler.h"

namespace ppve {

// Of memory that a server keeps for a point that a client has, with its share of the tree.
constexpr uint64_t kPointBytes = 24;

struct SessionLimits {
    uint64_t most_pixels = uint64_t(1) << 25;  // of a request
    // That are kept of what a client was sent, in kPointBytes each; then those clusters go that got nothing
    // new for longest.
    uint64_t most_points = uint64_t(1) << 25;
};

// What one answer cost and did, for reports.
struct AnswerReport {
    uint64_t id = 0;
    SampleCounts sampling;
    EliminationCounts elimination;
    int mantissa_bits = 0;
    double bound_px = 0;
    uint64_t image_bytes = 0, message_bytes = 0;
    uint64_t tree_points = 0, tree_clusters = 0, tree_bytes = 0;
    uint64_t deleted = 0, evicted = 0;  // leaves: by the client's wish, by the limit
    bool starts_anew = false;
    // The sampler failed, or memory: then the other figures are of what was done till then.
    bool is_refused = false;
    double sample_ms = 0, eliminate_ms = 0, encode_ms = 0, insert_ms = 0, total_ms = 0;
};

// One thread at a time.
class Session {
  public:
    // `sampler` outlives it, and may be shared by sessions that take turns.
    Session(Sampler& sampler, const std::string& scene, const SessionLimits& limits);

    Welcome welcome() const;

    // Takes a message of the client; what is to be said at once comes back.  Throws core::Error for a message
    // that is not a client's.
    std::vector<Refusal> take(Message&& message);

    bool has_request() const { return request_.has_value(); }

    // Answers the request that waits (there is one), or refuses it where the sampler fails.
    std::vector<std::byte> answer(AnswerReport& report);

    const Octree& tree() const { return tree_; }

  private:
    std::vector<ClusterId> take_deletions();
    std::vector<ClusterId> evict(uint64_t coming, size_t most) const;
    bool is_out_of_step(const Request& request);
    Answer make_answer(const Request& request, AnswerReport& report);
    void want_deleted(std::span<const uint64_t> leaves);

    Sampler& sampler_;
    std::string scene_;
    SessionLimits limits_;
    Box bounds_;
    Octree tree_;
    std::optional<Request> request_;
    uint64_t last_id_ = 0;
    std::vector<ClusterId> wanted_deleted_;
    bool is_behind_ = false;                  // the client holds another tree
    uint64_t anew_id_ = 0;                    // the answer that started the tree that is now
    std::map<uint64_t, uint64_t> checksums_;  // after answers that the client may still name
};

}  // namespace ppve
