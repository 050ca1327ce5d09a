// The files that are being served: who wants which of their blocks, and the requests under way for them.
//
// To each server as much is in flight as link_estimate.h says; whenever something has come, the block of the
// highest priority of all its files' queues is asked for next, with its neighbours of like priority.  What is
// in flight is not called back: at one and a half products of bandwidth and round trip there is nothing worth
// cancelling.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fetch/link_estimate.h"
#include "fetch/messages.h"
#include "fetch/request_queue.h"
#include "fetch/store.h"
#include "fetch/transport.h"
#include "net/event_loop.h"

namespace fetch {

class Downloads;
class Download;

// Whoever has a file open.  Subscriptions may not be made or destroyed from within these calls.
class Subscriber {
  public:
    virtual ~Subscriber() = default;
    virtual void opened(const Entry& entry) = 0;  // once
    virtual void arrived() = 0;                   // once for each want(), from within it perhaps
    virtual void ended(Reason reason, const std::string& why) = 0;  // the last call
    // It is being tried again; or, before opened(), what is to be known about the version that opens.
    virtual void trouble(Reason reason, const std::string& why) = 0;
};

// A file that a subscriber has open; closed when destroyed.
class Subscription {
  public:
    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;

    // Takes the place of the earlier wants.  Throws core::Error where a block is beyond the file, or the file
    // is not open yet.
    void want(std::vector<Want> wants);

  private:
    friend class Download;
    friend class Downloads;
    Subscription(std::shared_ptr<Download> download, Subscriber& subscriber);

    std::shared_ptr<Download> download_;
    Subscriber& subscriber_;
    std::vector<Want> wants_;  // by block
    bool is_told_ = false;     // of a block of the last want
    bool has_opened_ = false;
};

struct DownloadCounts {
    uint64_t opens = 0, opens_from_cache = 0, checks = 0, blocks_stored = 0, retries = 0, changed = 0;
};

struct DownloadOptions {
    unsigned most_retries = 5;  // failures in a row of a file until its subscribers are told that it is over
    // What the server has not confirmed for so long is asked about when it is opened; 0: always.
    double max_age_s = 600;
};

// Not thread-safe; runs in the event loop.
class Downloads {
  public:
    Downloads(net::EventLoop& loop, Store& store, const TransportOptions& transport,
              const DownloadOptions& options);
    ~Downloads();

    // Throws core::Error where it is no URL of http or https.
    std::unique_ptr<Subscription> open(const std::string& url, Subscriber& subscriber);
    bool is_open(const std::string& url) const { return downloads_.contains(url); }
    const DownloadCounts& counts() const { return counts_; }
    const TransportCounts& transport_counts() const { return transport_.counts(); }
    size_t size() const { return downloads_.size(); }
    size_t requests_in_flight() const;
    struct ServerState {
        std::string name;
        double bytes_per_s, round_trip_s;
        uint64_t window_bytes;
    };
    std::vector<ServerState> servers() const;

  private:
    friend class Download;
    friend class Subscription;
    struct Server;
    class Answer;

    void pump_soon(Server& server);
    void pump(Server& server);
    Download* best_of(Server& server);
    void forget(Download& download);
    uint64_t disk_bytes_in_flight() const;
    Server& server_for(const std::string& url);

    net::EventLoop& loop_;
    Store& store_;
    DownloadOptions options_;
    DownloadCounts counts_;
    std::map<std::string, std::unique_ptr<Server>> servers_;
    std::map<std::string, std::shared_ptr<Download>> downloads_;  // by URL
    struct Refusal {
        double until;
        std::string why;
    };
    std::map<std::string, Refusal> refusals_;  // of servers without ranges, by URL
    Transport transport_;                      // goes first: what it still holds are answers to the above
};

}  // namespace fetch
