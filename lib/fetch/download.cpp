#include "fetch/download.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "core/messages.h"

namespace fetch {

namespace {

constexpr double kFirstBackoff = 0.25, kMostBackoff = 30;
constexpr double kFullPause = 1;
constexpr double kRefusalMemory = 60;
constexpr size_t kMostRefusals = 1000;
constexpr double kMostCheckWait = 3;  // what is in the cache is not held back for longer

double backoff_s(unsigned failures) {
    return std::min(kMostBackoff, kFirstBackoff * std::exp2(double(std::min(failures, 16u)) - 1));
}

}  // namespace

// ---- an answer on its way ----

// Puts the bytes of one answer into the store, block by block as they come.
class Downloads::Answer : public RangeSink {
  public:
    Answer(std::shared_ptr<Download> download, const RangeRequest& request)
        : download_(std::move(download)),
          at_(request.first),
          left_(request.last - request.first + 1),
          last_(request.last),
          is_check_(request.is_check),
          sent_(net::steady_seconds()) {}

    void head(const RangeHead& head) override {
        const double now = net::steady_seconds();
        has_begun_ = true;
        link().answer_began(now, now - sent_ - head.set_up_s, head.header_bytes);
        if (download_->is_over_) return;
        const bool is_first = !download_->entry_;
        download_->take_head(head);
        if (is_first && download_->entry_) claim(head.last);
    }

    void bytes(std::span<const std::byte> bytes) override {
        link().bytes_came(net::steady_seconds(), bytes.size());
        left_ -= std::min<uint64_t>(left_, bytes.size());
        if (!download_->is_over_ && !is_given_up_ && !is_check_) store(bytes);
        download_->all_.pump_soon(download_->server_);
    }

    void end(const RangeEnd& end) override {
        link().request_ended(net::steady_seconds(), left_, has_begun_);
        --download_->server_.requests;
        if (end.streams > 0) download_->server_.streams = end.streams;
        if (end.connections > 0) link().set_connections(end.connections);
        --download_->requests_;
        if (is_check_) {
            if (!download_->is_over_) download_->take_check_end(end);
        } else {
            give_back();
            if (!download_->is_over_) download_->take_end(end);
        }
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
        if (whole > 0 && !put(entry, all.first(whole))) return;
        const auto rest = all.subspan(whole);
        part_ = std::vector<std::byte>(rest.begin(), rest.end());
        at_ += whole;
    }

    // False where the store does not take them: give_back() then begins with them.
    bool put(Entry& entry, std::span<const std::byte> bytes) {
        const uint32_t first = uint32_t(at_ / entry.block_bytes());
        const uint32_t count = uint32_t(blocks_in(bytes.size(), entry.block_bytes()));
        try {
            entry.put(first, bytes);
        } catch (const core::Error& error) {
            is_given_up_ = true;
            download_->store_failed(error);
            return false;
        }
        download_->failures_ = 0;
        download_->all_.counts_.blocks_stored += count;
        download_->tell_arrived(first, count);
        return true;
    }

    // The blocks of the first answer, which were not known before, are not to be asked for again.
    void claim(uint64_t last) {
        Entry& entry = *download_->entry_;
        for (uint64_t block = 0; block <= last / entry.block_bytes(); ++block)
            entry.set_state(uint32_t(block), BlockState::requested);
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
    bool is_check_;
    double sent_;
    bool has_begun_ = false;
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
    if (check_ == Check::needed) return std::numeric_limits<float>::infinity();
    if (is_stale_) merge_wants();
    return queue_.is_empty() ? -1 : queue_.head_priority();
}

// False where there is no room for it now.
bool Download::start_next() {
    if (!entry_) {
        start(0, kFirstBytes - 1);
        return true;
    }
    if (check_ == Check::needed) {
        start_check();
        return true;
    }
    const auto blocks = [&](uint64_t bytes) {
        return uint32_t(std::max<uint64_t>(1, bytes / entry_->block_bytes()));
    };
    const BlockRange range =
        queue_.take({blocks(server_.link.request_bytes(server_.streams)), server_.link.join_factor(),
                     blocks(server_.link.share_bytes(server_.streams))});
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
    send(request);
}

void Download::send(const RangeRequest& request) {
    ++requests_;
    ++server_.requests;
    server_.link.request_sent(net::steady_seconds(), request.last - request.first + 1);
    all_.transport_.start(request, std::make_shared<Downloads::Answer>(shared_from_this(), request));
}

// ---- whether the server still has this version ----

void Download::check_if_old() {
    if (check_ != Check::none) return;
    // Below 0 where the clock has been set back.
    const int64_t age_s = ::time(nullptr) - entry_->confirmed_at();
    if (age_s >= 0 && double(age_s) < all_.options_.max_age_s) return;
    check_ = Check::needed;
    ++all_.counts_.checks;
    check_timer_ = all_.loop_.after(kMostCheckWait, [this] {
        check_timer_ = 0;
        open_unchecked(core::text("server does not answer in %.0f s", kMostCheckWait));
    });
}

// For one byte, which comes where the server compares nothing.
void Download::start_check() {
    check_ = Check::under_way;
    send({url_, 0, 0, entry_->facts().bytes, entry_->facts().validator, false, true});
}

void Download::take_check_end(const RangeEnd& end) {
    using Verdict = RangeEnd::Verdict;
    switch (end.verdict) {
        case Verdict::done:
        case Verdict::unchanged:
        case Verdict::no_ranges:
        case Verdict::no_if_range:
            entry_->confirm();
            return end_check();
        case Verdict::changed:
            return renew(end.reason);
        case Verdict::refused:
            return end_all(Reason::failed, end.reason);
        case Verdict::retry:
        case Verdict::busy:
            return open_unchecked(end.reason);
    }
}

void Download::end_check() {
    check_ = Check::none;
    all_.loop_.cancel(check_timer_);
    check_timer_ = 0;
    tell_opened();
}

void Download::open_unchecked(const std::string& why) {
    if (check_ == Check::none) return;
    const std::string note = "cannot ask whether the file has changed: " + why;
    core::notice(url_ + ": " + note);
    tell_waiting(Reason::unchecked, note);
    end_check();
}

void Download::tell_waiting(Reason reason, const std::string& note) {
    for (Subscription* subscription : subscriptions_)
        if (!subscription->has_opened_) subscription->subscriber_.trouble(reason, note);
}

// Those who have the file open are told that it is over; those who still wait get the new version.
void Download::renew(const std::string& why) {
    ++all_.counts_.changed;
    entry_->mark_replaced();
    all_.store_.remove(url_);
    tell_waiting(Reason::renewed, why + "; what was cached of it is dropped");
    const auto waiting = std::stable_partition(subscriptions_.begin(), subscriptions_.end(),
                                               [](const Subscription* s) { return s->has_opened_; });
    const std::vector<Subscription*> moved(waiting, subscriptions_.end());
    subscriptions_.erase(waiting, subscriptions_.end());
    end_all(Reason::replaced, why);
    if (moved.empty()) return;
    const auto next = std::make_shared<Download>(all_, server_, url_);
    all_.downloads_[url_] = next;
    next->subscriptions_ = moved;
    for (Subscription* subscription : moved) subscription->download_ = next;
}

// ---- answers ----

void Download::take_head(const RangeHead& head) {
    if (entry_) {
        entry_->confirm();
        return;
    }
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
    if (check_ != Check::none) return;
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
    paused_until_ = std::max(paused_until_, net::steady_seconds() + seconds);
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
            all_.refusals_[url_] = {net::steady_seconds() + kRefusalMemory, end.reason};
            return end_all(Reason::failed, end.reason);
        case Verdict::refused:
            return end_all(Reason::failed, end.reason);
        case Verdict::changed:
            return renew(end.reason);
        case Verdict::unchanged:
            return;  // to checks alone
    }
}

void Download::try_again(const RangeEnd& end) {
    const double now = net::steady_seconds();
    // Of several requests that fail together, one counts.
    if (now < paused_until_) return;
    ++all_.counts_.retries;
    if (++failures_ > all_.options_.most_retries)
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

}  // namespace fetch
