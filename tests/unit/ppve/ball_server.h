// A server of the ball scene in the same process, as the other end of a Link; with faults on demand.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <variant>

#include "ball_scene.h"
#include "core/error.h"
#include "ppve/elimination.h"
#include "ppve/link.h"
#include "ppve/messages.h"
#include "ppve/octree.h"

namespace ppve::test {

struct Faults {
    std::atomic<uint64_t> lost_at{0};     // this answer's points are not in the server's own tree
    std::atomic<uint64_t> garbage_at{0};  // this answer is bytes of no meaning
    std::atomic<uint64_t> killed_at{0};   // the connection ends instead of this answer
    std::atomic<bool> is_silent{false};   // no answers
    std::atomic<bool> refuses{false};
    std::atomic<bool> cannot_connect{false};
    std::atomic<uint64_t> requests{0}, connections{0}, started_anew{0};
    std::atomic<uint64_t> most_width{0};
};

class BallServer : public Link {
  public:
    explicit BallServer(Faults& faults) : faults_(faults), tree_(shape_around(scene_bounds())) {
        if (faults.cannot_connect) throw core::Error("ppve://nowhere: cannot connect: Connection refused");
        ++faults.connections;
        Welcome welcome;
        welcome.bounds = scene_bounds();
        welcome.most_pixels = 4'000'000;
        welcome.most_points = 100'000'000;
        welcome.scene = "ball", welcome.sampler = "exact";
        next_ = format(welcome);
    }

    void send(std::span<const std::byte> message, double) override {
        const Message parsed = parse(message, "client");
        const auto& request = std::get<Request>(parsed);
        ++faults_.requests;
        faults_.most_width = std::max<uint64_t>(faults_.most_width, uint64_t(request.frustum.view.width));
        next_ = answer(request);
    }

    std::vector<std::byte> receive(double) override {
        if (is_killed_) throw core::Error("server: has gone");
        return faults_.is_silent ? std::vector<std::byte>{} : std::exchange(next_, {});
    }

  private:
    std::vector<std::byte> answer(const Request& request) {
        if (faults_.requests == faults_.garbage_at) return std::vector<std::byte>(100, std::byte(7));
        is_killed_ = faults_.requests == faults_.killed_at;
        if (faults_.refuses) return format(Refusal{request.id, "busy"});
        Answer answer;
        answer.id = request.id, answer.stamp = request.stamp;
        answer.starts_anew = request.octree_checksum != tree_.checksum();
        faults_.started_anew += answer.starts_anew;
        answer.deleted = request.deletions;
        DepthImage image = sample(request.frustum, request.wants_normals, request.footprint_px);
        tree_.apply({answer.starts_anew, answer.deleted, {}, 0, nullptr});
        answer.samples = image.samples();
        const Eliminated eliminated = eliminate(tree_, {request.elimination, request.epsilon, 1.4}, image);
        answer.replaced = write_removals(eliminated.removed);
        answer.frustum = image.frustum;
        answer.coding = image.coding;
        answer.footprint_px = image.footprint_px;
        answer.has_normals = !image.normal.empty();
        answer.codec = request.codec;
        answer.image = encode(image, request.codec);
        answer.samples_kept = eliminated.counts.kept;
        if (faults_.requests == faults_.lost_at)
            tree_.apply({true, {}, {}, 0, nullptr});
        else
            tree_.apply({false, {}, eliminated.removed, request.id, &image});
        answer.octree_checksum = tree_.checksum();
        return format(answer);
    }

    Faults& faults_;
    Octree tree_;
    std::vector<std::byte> next_;
    bool is_killed_ = false;
};

}  // namespace ppve::test
