// Ranges of files over HTTP: requests run at the same time on kept-alive connections, or multiplexed on one
// where the server speaks HTTP/2.  Everything that can be wrong with an answer is found before its bytes are
// handed on.
//
// What is checked: what verdict.h says; that the body is as long as its header says; that certificates are
// good; that redirects, 5 at most, go to http or https, and never from https to http.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fetch/header_rules.h"
#include "fetch/verdict.h"
#include "net/event_loop.h"

namespace fetch {

struct RangeHead {
    uint64_t total = 0;
    Validator validator;
    uint64_t last = 0;          // what comes; a server may send less than it was asked for
    uint64_t header_bytes = 0;  // as it would be without HTTP/2
    double set_up_s = 0;  // what went by before the request was on its way: connecting, and waiting for that
};

// Gets an answer, in turn: head() once, bytes() in the order of the file and never more than head().last
// tells, end() once.  Where the answer is not right, only end().
class RangeSink {
  public:
    virtual ~RangeSink() = default;
    virtual void head(const RangeHead& head) = 0;
    virtual void bytes(std::span<const std::byte> bytes) = 0;
    virtual void end(const RangeEnd& end) = 0;
};

struct TransportOptions {
    double stall_s = 10;       // without a byte a request is given up
    unsigned connections = 6;  // to a server, with HTTP/1.1
    unsigned streams = 100;    // with HTTP/2
    std::string ca_file;       // certificates to trust instead of the system's
    HeaderRules header_rules;  // where one is for a URL, redirects of it are not followed
    std::string user_agent = "qs-fetch";
    double bytes_per_s = 0, round_trip_s = 0;  // a slow link to try out, slow_link.h
};

struct TransportCounts {
    uint64_t requests = 0, header_bytes = 0, body_bytes = 0;
};

// Not thread-safe; runs in the event loop, which outlives it.
class Transport {
  public:
    Transport(net::EventLoop& loop, TransportOptions options);
    ~Transport();
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;

    // The sink is held until its end().  Nothing is called from within start().
    void start(const RangeRequest& request, std::shared_ptr<RangeSink> sink);
    const TransportCounts& counts() const;

  private:
    struct Transfer;
    struct State;
    std::unique_ptr<State> state_;
};

// "https://host:port" of a URL, in lower case.  Throws core::Error, in which the URL is not named, where it
// is none of http or https, is longer than 8 KiB, or holds other than printable ASCII.
std::string server_of(const std::string& url);

}  // namespace fetch
