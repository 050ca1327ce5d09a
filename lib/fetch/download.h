// One file that is being served, and the server that it is at; internal to downloads.h.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fetch/downloads.h"

namespace fetch {

// What a server sends before it waits for the first acknowledgement: two round trips to a first picture.
constexpr uint64_t kFirstBytes = 13 * 1024;

// What so many bytes may take on disk at most: pages that they share with others, at both ends and of the
// sums.
constexpr uint64_t disk_bytes(uint64_t bytes) {
    return bytes + bytes / 64 + 4 * 4096;
}

struct Downloads::Server {
    std::string name;
    LinkEstimate link;
    unsigned streams = 6;   // until it is known
    unsigned requests = 0;  // in flight
    double paused_until = 0;
    net::EventLoop::TimerId timer = 0;
    std::vector<Download*> downloads;
};

// One URL, from the first subscriber until neither one nor a request is left.
class Download : public std::enable_shared_from_this<Download> {
  public:
    Download(Downloads& all, Downloads::Server& server, std::string url)
        : all_(all), server_(server), url_(std::move(url)), entry_(all.store_.find(url_)) {
        server_.downloads.push_back(this);
    }
    ~Download() {
        all_.loop_.cancel(check_timer_);
        std::erase(server_.downloads, this);
    }
    Download(const Download&) = delete;
    Download& operator=(const Download&) = delete;

  private:
    friend class Downloads;
    friend class Downloads::Answer;
    friend class Subscription;

    void merge_wants();
    bool is_ready(double now) { return !is_over_ && now >= paused_until_; }
    // How urgent its next request is; negative: it has none.
    float urgency();
    bool start_next();
    void start(uint64_t first, uint64_t last);
    void send(const RangeRequest& request);
    void check_if_old();
    void start_check();
    void take_check_end(const RangeEnd& end);
    void end_check();
    void open_unchecked(const std::string& why);
    void renew(const std::string& why);
    void tell_waiting(Reason reason, const std::string& note);
    void take_head(const RangeHead& head);
    void tell_opened();
    void tell_arrived(uint32_t first, uint32_t count);
    void tell_trouble(Reason reason, const std::string& why);
    void store_failed(const core::Error& error);
    void pause(double seconds);
    void take_end(const RangeEnd& end);
    void try_again(const RangeEnd& end);
    void end_all(Reason reason, const std::string& why);

    Downloads& all_;
    Downloads::Server& server_;
    std::string url_;
    std::shared_ptr<Entry> entry_;  // null until the first answer
    std::vector<Subscription*> subscriptions_;
    RequestQueue queue_;
    bool is_stale_ = false;  // the queue is not what the subscriptions want
    bool may_send_if_range_ = true;
    bool is_over_ = false;
    unsigned requests_ = 0;  // in flight
    unsigned failures_ = 0;  // in a row
    double paused_until_ = 0;
    // While the server is asked whether it has changed, nobody else is let in.
    enum class Check { none, needed, under_way };
    Check check_ = Check::none;
    net::EventLoop::TimerId check_timer_ = 0;
};

}  // namespace fetch
