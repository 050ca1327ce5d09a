// A server of progressive meshes: sessions as in the paper (Kim, Lee, Kobbelt, section 5.1), on net::Server.
//
// One thread.  A view takes the place of the one before it, after at most one turn: a packet, or as many as
// make an answer that begins again worth its beginning.  A client that does not read has no packets made for
// it.  Nothing is kept of a client but its record (SentRecord), and for a few the answer that is being made;
// one that was given up for others begins again.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/json.h"
#include "net/server.h"
#include "pm/messages.h"
#include "pm/served_model.h"

namespace pm {

struct ServerOptions {
    net::ServerLimits limits;  // but most_frame_bytes, which follows from the models
    uint32_t packet_decisions = 512;
};

// Answers that are not at their end and wait for their next turn.  More would take memory, and save little:
// an answer begins again at the cost of a small part of a packet for each thousand splits that were sent.
constexpr size_t kMostUnfinished = 2;

// A model and the name that clients know it by.
struct CatalogueEntry {
    std::string name;
    std::string path;
};

// Not thread-safe; `loop` outlives it.
class Server {
  public:
    // Throws core::Error where a model cannot be served, or two have one name.
    Server(net::EventLoop& loop, const std::vector<CatalogueEntry>& catalogue, const ServerOptions& options);
    ~Server();

    void listen(net::Listener listener);
    // On standard input and output.
    void serve_one(core::Descriptor in, core::Descriptor out);

    // Counters, as in pm-serve(1).
    core::Json status() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pm
