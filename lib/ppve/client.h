// The client of a point-sampling server: keeps the point model as new as the server makes it, in a thread of
// its own, and never lets whoever draws wait.
//
// Ge et al. 2006, sections 3 and 5.  What is drawn is a model that is not changed any more; each answer makes
// another one, which shares all that is the same.  A server that is gone, or sends what is no message, leaves
// the last model to be drawn while the client connects again and again; a tree that has come out of step with
// the server's is begun anew by the next answer.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geom/camera.h"
#include "ppve/client/reconstruction.h"
#include "ppve/link.h"
#include "ppve/messages.h"

namespace ppve {

struct ClientOptions {
    int width = 1280, height = 800;  // of depth images while the eye moves, without their margin
    double bound_px = 0.01;          // of depth errors; 0: as single precision
    Codec codec = Codec::planes;
    Elimination elimination = Elimination::filtered;
    double epsilon = 0;  // Elimination::paper: world units
    bool wants_normals = false;
    bool predicts = true;              // asks for where the eye will be, and for a margin about it
    uint64_t most_bytes = 1ull << 30;  // of points; clusters that were not drawn for longest go first
    double keep_s = 60;                // clusters that were not drawn for so long go
    double rest_s = 0.15;              // an eye that is still for so long is at rest
    double answer_timeout_s = 60;
};

// All since the start.
struct ClientCounts {
    uint64_t updates = 0, updates_at_rest = 0, refusals = 0;
    uint64_t bytes_received = 0;  // of messages
    uint64_t samples = 0, samples_kept = 0, points_removed = 0, clusters_deleted = 0;
    uint64_t out_of_step = 0, connections = 0, failures = 0;
    uint64_t points = 0, clusters = 0, bytes = 0, most_bytes = 0;  // now; and the most there ever were
    double latency_s = 0;                                          // from asking to having
    double server_ms = 0, take_in_ms = 0;  // of the last update: what the server says, decoding and inserting
    std::string failure;                   // the last
};

// What is looked at.
struct Gaze {
    double time_s = 0;  // of the session; grows
    geom::Camera camera;
    std::vector<geom::View> eyes;  // one or two, on the client's screen
    bool is_still = false;         // and stays there: as fine as the screen at once
};

class Client {
  public:
    using OpenLink = std::function<std::unique_ptr<Link>()>;

    // Connects in its own thread.  `open` is called there, again where a connection has ended.
    Client(OpenLink open, const ClientOptions& options);
    ~Client();

    // Never waits for the server.  One thread calls these.
    void look(const Gaze& gaze);
    // The newest model; empty before the first update.  `is_at_rest`: it holds what was asked for at rest.
    std::shared_ptr<const PointModel> model() const;
    // `seen`: as Reconstruction::draw() says, of a model that was drawn now.
    void note_drawn(const PointModel& model, const std::vector<uint8_t>& seen);
    // The newest update was made for an eye at rest where it is now.
    bool is_settled() const;
    ClientCounts counts() const;

    // For pictures that are to be complete: waits until is_settled(), or a recorded session is over.  Throws
    // core::Error where the server refuses, the first connection has failed, or later three in a row.
    void wait_until_settled();
    // Waits for the scene's box, which the server says first.  Throws likewise.
    Box wait_for_bounds();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ppve
