#include "fetch/downloads.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/program.h"

namespace fetch {

namespace {

// What a server sends before it waits for the first acknowledgement: two round trips to a first picture.
constexpr uint64_t kFirstBytes = 13 * 1024;
constexpr unsigned kStreamsUntilKnown = 6;
constexpr double kFirstBackoff = 0.25, kMostBackoff = 30;
constexpr double kFullPause = 1;
constexpr double kRefusalMemory = 60;
constexpr size_t kMostRefusals = 1000, kMostServers = 1000;

// What so many bytes may take on disk at most: pages that they share with others, at both ends and of the
// sums.
constexpr uint64_t disk_bytes(uint64_t bytes) {
    return bytes + bytes / 64 + 4 * 4096;
}

double backoff_s(unsigned failures) {
    return std::min(kMostBackoff, kFirstBackoff * std::exp2(double(std::min(failures, 16u)) - 1));
}

}  // namespace

struct Downloads::Server {
    std::string name;
    LinkEstimate link;
    unsigned streams = kStreamsUntilKnown;
    unsigned requests = 0;  // in flight
    double paused_until = 0;
    EventLoop::TimerId timer = 0;
    std::vector<Download*> downloads;
};

// One URL, from the first subscriber until neither one nor a request is left.
class Download : public std::enable_shared_from_this<Download> {
  public:
    Download(Downloads& all, Downloads::Server& server, std::string url)
        : all_(all), server_(server), url_(std::move(url)), entry_(all.store_.find(url_)) {
        server_.downloads.push_back(this);
    }
    ~Download() { std::erase(server_.downloads, this); }
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
};

// ---- an answer on its way ----

// Puts the bytes of one answer into the store, block by block as they come.
class Downloads::Answer : public RangeSink {
  public:
    Answer(std::shared_ptr<Download> download, uint64_t first, uint64_t last)
        : download_(std::move(download)),
          at_(first),
          left_(last - first + 1),
          last_(last),
          sent_(steady_seconds()) {}

    void head(const RangeHead& head) override {
        const double now = steady_seconds();
        link().answer_began(now, now - sent_);
        if (!download_->is_over_) download_->take_head(head);
    }

    void bytes(std::span<const std::byte> bytes) override {
        link().bytes_came(steady_seconds(), bytes.size());
        left_ -= std::min<uint64_t>(left_, bytes.size());
        if (!download_->is_over_ && !is_given_up_) store(bytes);
        download_->all_.pump_soon(download_->server_);
    }

    void end(const RangeEnd& end) override {
        link().request_ended(steady_seconds(), left_);
        --download_->server_.requests;
        if (end.streams > 0) download_->server_.streams = end.streams;
        give_back();
        --download_->requests_;
        if (!download_->is_over_) download_->take_end(end);
        download_->all_.pump_soon(download_->server_);
        download_->all_.forget(*download_);
    }

  private:
    LinkEstimate& link() { return download_->server_.link; }

    void store(std::span<const std::byte> bytes) {
        Entry& entry = *download_->entry_;
        std::span<const std::byte> all = bytes;
        if (!part_.empty()) {
            part_.insert(part_.end(), bytes.begin(), bytes.end());
            all = part_;
        }
        const uint64_t end = at_ + all.size();
        const uint64_t whole =
            end == entry.facts().bytes ? end - at_ : all.size() / entry.block_bytes() * entry.block_bytes();
        if (whole > 0) put(entry, all.first(whole));
        const auto rest = all.subspan(whole);
        part_ = std::vector<std::byte>(rest.begin(), rest.end());
        at_ += whole;
    }

    void put(Entry& entry, std::span<const std::byte> bytes) {
        const uint32_t first = uint32_t(at_ / entry.block_bytes());
        const uint32_t count = uint32_t(blocks_in(bytes.size(), entry.block_bytes()));
        try {
            entry.put(first, bytes);
        } catch (const core::Error& error) {
            is_given_up_ = true;
            download_->store_failed(error);
            return;
        }
        download_->failures_ = 0;
        download_->all_.counts_.blocks_stored += count;
        download_->tell_arrived(first, count);
    }

    // The blocks that have not come are nobody's again.
    void give_back() {
        if (!download_->entry_) return;
        Entry& entry = *download_->entry_;
        const uint64_t end = std::min<uint64_t>(last_ / entry.block_bytes() + 1, entry.block_count());
        for (uint64_t block = at_ / entry.block_bytes(); block < end; ++block) {
            if (entry.state(uint32_t(block)) != BlockState::requested) continue;
            entry.set_state(uint32_t(block), BlockState::absent);
            download_->is_stale_ = true;
        }
    }

    std::shared_ptr<Download> download_;
    uint64_t at_;    // of the first byte that is not stored
    uint64_t left_;  // bytes that have not come
    uint64_t last_;
    double sent_;
    bool is_given_up_ = false;     // the store does not take it
    std::vector<std::byte> part_;  // of a block
};

// ---- Download ----

void Download::merge_wants() {
    is_stale_ = false;
    queue_.for_each([&](uint32_t block) {
        if (entry_->state(block) == BlockState::wanted) entry_->set_state(block, BlockState::absent);
    });
    std::vector<Want> merged;
    for (const Subscription* subscription : subscriptions_)
        for (const Want& want : subscription->wants_)
            if (const BlockState state = entry_->state(want.block);
                state == BlockState::absent || state == BlockState::wanted)
                merged.push_back(want);
    for (const Want& want : merged) entry_->set_state(want.block, BlockState::wanted);
    queue_.replace(std::move(merged));
}

float Download::urgency() {
    if (!entry_)
        return requests_ == 0 && !subscriptions_.empty() ? std::numeric_limits<float>::infinity() : -1;
    if (is_stale_) merge_wants();
    return queue_.is_empty() ? -1 : queue_.head_priority();
}

// False where there is no room for it now.
bool Download::start_next() {
    if (!entry_) {
        start(0, kFirstBytes - 1);
        return true;
    }
    const uint64_t most =
        std::max<uint64_t>(1, server_.link.request_bytes(server_.streams) / entry_->block_bytes());
    const BlockRange range = queue_.take(uint32_t(most), server_.link.join_factor());
    const uint64_t first = uint64_t{range.first} * entry_->block_bytes();
    const uint64_t end =
        std::min(entry_->facts().bytes, first + uint64_t{range.count} * entry_->block_bytes());
    if (!all_.store_.make_room(all_.disk_bytes_in_flight() + disk_bytes(end - first))) {
        is_stale_ = true;
        pause(kFullPause);
        tell_trouble(Reason::full, "the cache is full of blocks that are in use; --limit sets its size");
        return false;
    }
    for (uint32_t block = range.first; block != range.first + range.count; ++block)
        entry_->set_state(block, BlockState::requested);
    start(first, end - 1);
    return true;
}

void Download::start(uint64_t first, uint64_t last) {
    RangeRequest request{url_, first, last, 0, {}, may_send_if_range_};
    if (entry_) {
        request.total = entry_->facts().bytes;
        request.validator = entry_->facts().validator;
    }
    ++requests_;
    ++server_.requests;
    server_.link.request_sent(steady_seconds(), last - first + 1);
    all_.transport_.start(request, std::make_shared<Downloads::Answer>(shared_from_this(), first, last));
}

void Download::take_head(const RangeHead& head) {
    if (entry_) return;
    try {
        const uint64_t least = all_.disk_bytes_in_flight() + 2 * disk_bytes(0) +
                               map_bytes(blocks_in(std::min(head.total, kMostFileBytes), kBlockBytes));
        if (head.total <= kMostFileBytes && !all_.store_.make_room(least))
            throw core::Error("the cache is full of blocks that are in use; --limit sets its size");
        entry_ = all_.store_.create({url_, head.total, head.validator});
    } catch (const core::Error& error) {
        end_all(Reason::failed, error.what());
        return;
    }
    if (head.validator == Validator())
        core::notice(url_ + ": the server names no version; of a change only another size is noticed");
    tell_opened();
}

void Download::tell_opened() {
    for (Subscription* subscription : subscriptions_) {
        if (subscription->has_opened_) continue;
        subscription->has_opened_ = true;
        subscription->subscriber_.opened(*entry_);
    }
}

void Download::tell_arrived(uint32_t first, uint32_t count) {
    for (Subscription* subscription : subscriptions_) {
        if (subscription->is_told_) continue;
        const auto& wants = subscription->wants_;
        const auto at = std::lower_bound(wants.begin(), wants.end(), first,
                                         [](const Want& want, uint32_t block) { return want.block < block; });
        if (at == wants.end() || at->block - first >= count) continue;
        subscription->is_told_ = true;
        subscription->subscriber_.arrived();
    }
}

void Download::tell_trouble(Reason reason, const std::string& why) {
    core::notice(url_ + ": " + why);
    for (Subscription* subscription : subscriptions_) subscription->subscriber_.trouble(reason, why);
}

void Download::store_failed(const core::Error& error) {
    if (!dynamic_cast<const DiskFull*>(&error)) {
        end_all(Reason::failed, error.what());
        return;
    }
    const uint64_t held = all_.store_.held_bytes();
    all_.store_.shrink_to(held - held / 16);
    pause(kFullPause);
    tell_trouble(Reason::full, error.what());
}

void Download::pause(double seconds) {
    paused_until_ = std::max(paused_until_, steady_seconds() + seconds);
    all_.loop_.after(seconds, [self = weak_from_this()] {
        if (const auto download = self.lock()) download->all_.pump_soon(download->server_);
    });
}

void Download::take_end(const RangeEnd& end) {
    using Verdict = RangeEnd::Verdict;
    switch (end.verdict) {
        case Verdict::done:
            return;
        case Verdict::no_if_range:
            // Of each of those that are under way.  One without If-Range that gets the whole file ends it.
            may_send_if_range_ = false;
            return;
        case Verdict::retry:
        case Verdict::busy:
            return try_again(end);
        case Verdict::no_ranges:
            if (all_.refusals_.size() >= kMostRefusals) all_.refusals_.clear();
            all_.refusals_[url_] = {steady_seconds() + kRefusalMemory, end.reason};
            return end_all(Reason::failed, end.reason);
        case Verdict::refused:
            return end_all(Reason::failed, end.reason);
        case Verdict::changed:
            ++all_.counts_.changed;
            entry_->mark_replaced();
            all_.store_.remove(url_);
            return end_all(Reason::replaced, end.reason);
    }
}

void Download::try_again(const RangeEnd& end) {
    const double now = steady_seconds();
    // Of several requests that fail together, one counts.
    if (now < paused_until_) return;
    ++all_.counts_.retries;
    if (++failures_ > all_.most_retries_)
        return end_all(Reason::failed, core::text("%s; tried %u times", end.reason.c_str(), failures_));
    const double wait = std::max(end.retry_after_s, backoff_s(failures_));
    if (end.verdict == RangeEnd::Verdict::busy)
        server_.paused_until = std::max(server_.paused_until, now + wait);
    pause(wait);
    tell_trouble(Reason::failed, core::text("%s; the next try is in %.3g s", end.reason.c_str(), wait));
}

void Download::end_all(Reason reason, const std::string& why) {
    is_over_ = true;
    core::warn(url_ + ": " + why);
    for (Subscription* subscription : subscriptions_) subscription->subscriber_.ended(reason, why);
}

// ---- Subscription ----

Subscription::Subscription(std::shared_ptr<Download> download, Subscriber& subscriber)
    : download_(std::move(download)), subscriber_(subscriber) {
    download_->subscriptions_.push_back(this);
}

Subscription::~Subscription() {
    std::erase(download_->subscriptions_, this);
    download_->is_stale_ = true;
    download_->all_.forget(*download_);
}

void Subscription::want(std::vector<Want> wants) {
    if (!download_->entry_) throw core::Error("blocks are wanted of a file that is not open");
    const Entry& entry = *download_->entry_;
    for (const Want& want : wants)
        if (want.block >= entry.block_count()) throw core::Error("a block is wanted that is beyond the file");
    std::sort(wants.begin(), wants.end(), [](const Want& a, const Want& b) { return a.block < b.block; });
    wants_ = std::move(wants);
    download_->is_stale_ = true;
    is_told_ = std::any_of(wants_.begin(), wants_.end(),
                           [&](const Want& want) { return entry.state(want.block) == BlockState::present; });
    if (is_told_) subscriber_.arrived();
    download_->all_.pump_soon(download_->server_);
}

// ---- Downloads ----

Downloads::Downloads(EventLoop& loop, Store& store, const TransportOptions& transport, unsigned most_retries)
    : loop_(loop), store_(store), most_retries_(most_retries), transport_(loop, transport) {}

Downloads::~Downloads() {
    for (const auto& [name, server] : servers_) loop_.cancel(server->timer);
}

Downloads::Server& Downloads::server_for(const std::string& url) {
    const std::string name = server_of(url);
    if (servers_.size() >= kMostServers)
        std::erase_if(servers_, [](const auto& known) {
            return known.second->downloads.empty() && known.second->timer == 0;
        });
    std::unique_ptr<Server>& server = servers_[name];
    if (!server) {
        server = std::make_unique<Server>();
        server->name = name;
    }
    return *server;
}

std::unique_ptr<Subscription> Downloads::open(const std::string& url, Subscriber& subscriber) {
    if (const auto refusal = refusals_.find(url); refusal != refusals_.end()) {
        if (steady_seconds() < refusal->second.until) throw core::Error(refusal->second.why);
        refusals_.erase(refusal);
    }
    ++counts_.opens;
    std::shared_ptr<Download>& download = downloads_[url];
    try {
        // One that is over is left to those who still hold it.
        if (!download || download->is_over_)
            download = std::make_shared<Download>(*this, server_for(url), url);
    } catch (const core::Error&) {
        downloads_.erase(url);
        throw;
    }
    std::unique_ptr<Subscription> subscription(new Subscription(download, subscriber));
    if (download->entry_) {
        ++counts_.opens_from_cache;
        loop_.after(0, [weak = std::weak_ptr(download)] {
            if (const auto opened = weak.lock(); opened && !opened->is_over_) opened->tell_opened();
        });
    }
    pump_soon(download->server_);
    return subscription;
}

void Downloads::forget(Download& download) {
    if (!download.subscriptions_.empty() || download.requests_ > 0) return;
    const auto found = downloads_.find(download.url_);
    if (found != downloads_.end() && found->second.get() == &download) downloads_.erase(found);
}

// After what else there is to do now: many messages and answers make one look at the queues.
void Downloads::pump_soon(Server& server) {
    if (server.timer != 0) return;
    server.timer = loop_.after(0, [this, &server] {
        server.timer = 0;
        pump(server);
    });
}

Download* Downloads::best_of(Server& server) {
    const double now = steady_seconds();
    Download* best = nullptr;
    float most = -1;
    for (Download* download : server.downloads) {
        if (!download->is_ready(now)) continue;
        const float urgency = download->urgency();
        if (urgency > most) {
            most = urgency;
            best = download;
        }
    }
    return best;
}

void Downloads::pump(Server& server) {
    const double now = steady_seconds();
    if (now < server.paused_until) {
        server.timer = loop_.after(server.paused_until - now, [this, &server] {
            server.timer = 0;
            pump(server);
        });
        return;
    }
    while (server.requests < server.streams) {
        const bool is_full =
            server.requests > 0 && server.link.in_flight_bytes() >= server.link.window_bytes();
        if (is_full) return;
        Download* const best = best_of(server);
        if (!best) return;
        best->start_next();
    }
}

uint64_t Downloads::disk_bytes_in_flight() const {
    uint64_t bytes = 0;
    for (const auto& [name, server] : servers_)
        bytes += disk_bytes(server->link.in_flight_bytes()) + server->requests * disk_bytes(0);
    return bytes;
}

size_t Downloads::requests_in_flight() const {
    size_t requests = 0;
    for (const auto& [name, server] : servers_) requests += server->requests;
    return requests;
}

std::vector<Downloads::ServerState> Downloads::servers() const {
    std::vector<ServerState> states;
    for (const auto& [name, server] : servers_)
        states.push_back(
            {name, server->link.bytes_per_s(), server->link.round_trip_s(), server->link.window_bytes()});
    return states;
}

}  // namespace fetch
