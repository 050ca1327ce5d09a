// Following a camera path at a server: a view for each camera, and what it costs.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "core/json.h"
#include "geom/camera.h"
#include "net/address.h"
#include "pm/client.h"

namespace pm {

struct FollowOptions {
    int width = 1280, height = 720;  // pixels of the pictures that the views are for
    double threshold_px = 1;
    Culling culling = Culling::on;
    Service service = Service::selective;
    bool in_real_time = false;  // views by the times of the path, whether or not the ones before are complete
    double timeout_s = 60;      // with nothing from the server
    int most_retries = 5;       // connections in a row that are lost without anything new
};

struct FrameCosts {
    int frame = 0;
    double time_s = 0;
    uint64_t bytes_up = 0, bytes_down = 0;       // since the frame before
    uint64_t requests = 0, splits_received = 0;  // likewise; views or lists
    uint32_t splits = 0;                         // of the front that is shown
    uint64_t faces = 0;
    bool is_complete = false;
    double first_packet_ms = 0, done_ms = 0;  // since the view was sent; 0 where nothing was asked
    double refine_ms = 0;                     // choosing and changing the front
    uint64_t resumed = 0;                     // connections that were lost and taken up again
};
core::Json to_json(const FrameCosts& costs);

// Makes a connection to the server.
using Connect = std::function<net::FrameStream()>;
Connect connector(const net::Address& address, double timeout_s);

// A client that takes a lost connection up again, from what it has received.
class Follower {
  public:
    // Throws core::Error as Client::open() and Client::resume(); a state that is not null is gone on with, by
    // the service that it is of.
    Follower(Connect connect, std::string name, const FollowOptions& options,
             std::unique_ptr<ClientState> state = nullptr);

    // Shows the frame: asks for what it lacks, and takes what comes until it is complete, in real time until
    // the next one is due at the latest, of which `next_time_s` is the time in the path.
    FrameCosts show(int number, const geom::Camera& camera, std::optional<double> next_time_s = {});
    // For the frames to come.
    void look_through(int width, int height, double threshold_px);
    // Nor shall a frame to come wait longer than this for what it lacks.
    void wait_at_most(double patience_s) { patience_s_ = patience_s; }
    // The front of the last frame that was shown.
    const Front& front() { return client_->refine(); }
    const ClientState& state() const { return client_->state(); }
    uint64_t bytes_up() const { return bytes_up_ + client_->stream().bytes_sent(); }
    uint64_t bytes_down() const { return bytes_down_ + client_->stream().bytes_received(); }

  private:
    void connect(std::unique_ptr<ClientState> state);
    void reconnect();
    bool ask(const View& view);
    void wait_for_end(double until_s, FrameCosts& costs);

    Connect connect_;
    std::string name_;
    FollowOptions options_;
    std::unique_ptr<Client> client_;
    uint64_t bytes_up_ = 0, bytes_down_ = 0, requests_ = 0;  // of earlier connections
    uint64_t told_up_ = 0, told_down_ = 0, told_splits_ = 0, told_requests_ = 0, resumed_ = 0;
    uint64_t splits_at_loss_ = 0;
    int losses_ = 0;
    double patience_s_ = std::numeric_limits<double>::infinity();
    double begun_s_ = -1, asked_s_ = 0, path_begin_s_ = 0;
    View view_;
};

}  // namespace pm
