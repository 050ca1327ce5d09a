#include "net/connection.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>

namespace net {

namespace {

constexpr size_t kReadBytes = 16 << 10;
constexpr double kLingerSeconds = 2;

bool is_no_failure() {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

void Session::input_ended(Connection& connection) {
    connection.finish();
}

Connection::Connection(EventLoop& loop, core::Descriptor socket, const ConnectionLimits& limits, Gone gone)
    : Connection(loop, std::move(socket), core::Descriptor(), limits, std::move(gone)) {}

Connection::Connection(EventLoop& loop, core::Descriptor in, core::Descriptor out,
                       const ConnectionLimits& limits, Gone gone)
    : loop_(loop),
      in_(std::move(in)),
      out_(std::move(out)),
      limits_(limits),
      gone_(std::move(gone)),
      reader_(limits.most_frame_bytes),
      last_in_(steady_seconds()),
      frame_begun_(last_in_),
      last_taken_(last_in_) {
    ::fcntl(in_.get(), F_SETFL, O_NONBLOCK);
    if (out_) ::fcntl(out_.get(), F_SETFL, O_NONBLOCK);
}

Connection::~Connection() {
    for (const EventLoop::TimerId timer : {timer_, turn_timer_, more_timer_}) loop_.cancel(timer);
    loop_.unwatch(in_.get());
    loop_.unwatch(out());
}

void Connection::start(std::unique_ptr<Session> session) {
    session_ = std::move(session);
    update_watches();
    arm_timer();
}

// ---- what comes ----

// Failures of a client end its own connection, and nothing else.
template <class Work>
void Connection::guarded(const Work& work) {
    try {
        work();
    } catch (const core::Error& error) {
        drop(error.what());
    } catch (const std::bad_alloc&) {
        drop("there is not enough memory for it");
    }
}

void Connection::on_event(uint32_t events) {
    // A hang-up while nothing is read would be told again and again.
    if ((events & (EPOLLERR | EPOLLHUP)) && !(events & EPOLLIN)) {
        is_input_ended_ = true;
        return be_gone();
    }
    if (state_ == State::lingering) return discard_input();
    if (events & EPOLLOUT) write();
    if (events & EPOLLIN) read();
}

void Connection::read() {
    if (state_ != State::open || is_input_ended_) return;
    std::array<std::byte, kReadBytes> bytes;
    const ssize_t size = ::read(in_.get(), bytes.data(), bytes.size());
    if (size < 0 && is_no_failure()) return;
    if (size < 0) return be_gone();
    if (size == 0) {
        is_input_ended_ = true;
        update_watches();
        if (reader_.is_within()) return drop("went within a message");
        return guarded([&] { session_->input_ended(*this); });
    }
    counts_.bytes_in += uint64_t(size);
    last_in_ = steady_seconds();
    if (!reader_.is_within()) frame_begun_ = last_in_;
    reader_.add(std::span(bytes).first(size_t(size)));
    take_frames();
}

// Some frames; what is left of those that have come is taken when others have had their turn, or when the
// client has read what it was sent.
void Connection::take_frames() {
    guarded([&] {
        for (int taken = 0; state_ == State::open; ++taken) {
            if (queued_bytes_ > limits_.most_queued_bytes) return;
            if (taken == limits_.frames_a_turn) {
                if (more_timer_ == 0)
                    more_timer_ = loop_.after(0, [this] {
                        more_timer_ = 0;
                        take_frames();
                    });
                return;
            }
            const std::span<const std::byte> body = reader_.next();
            if (body.empty()) return;
            ++counts_.frames_in;
            frame_begun_ = last_in_;
            session_->received(body);
        }
    });
    update_watches();
    arm_timer();
}

// ---- what goes ----

void Connection::send(std::span<const std::byte> body) {
    if (state_ != State::open) return;
    queue_.push_back(to_frame(body));
    if (queued_bytes_ == 0) last_taken_ = steady_seconds();
    queued_bytes_ += queue_.back().size();
    ++counts_.frames_out;
    write_some();
    update_watches();
    arm_timer();
}

// False where the other end has gone.  Calls nothing that could end this object.
bool Connection::write_some() {
    while (!queue_.empty()) {
        std::array<iovec, 64> parts;
        size_t count = 0, offset = front_sent_;
        for (auto frame = queue_.begin(); frame != queue_.end() && count != parts.size(); ++frame, offset = 0)
            parts[count++] = {frame->data() + offset, frame->size() - offset};
        msghdr message = {};
        message.msg_iov = parts.data();
        message.msg_iovlen = count;
        // A pipe is no socket; SIGPIPE is ignored by all programs (core/program.h).
        const ssize_t size = out_ ? ::writev(out(), parts.data(), int(count))
                                  : ::sendmsg(out(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (size < 0) return is_no_failure();
        counts_.bytes_out += uint64_t(size);
        queued_bytes_ -= size_t(size);
        last_taken_ = steady_seconds();
        size_t left = size_t(size) + front_sent_;
        while (!queue_.empty() && left >= queue_.front().size()) {
            left -= queue_.front().size();
            queue_.pop_front();
        }
        front_sent_ = left;
    }
    return true;
}

void Connection::write() {
    const bool was_full = queued_bytes_ > limits_.most_queued_bytes;
    if (!write_some()) return be_gone();
    if (queue_.empty()) return all_is_sent();
    if (was_full && queued_bytes_ <= limits_.most_queued_bytes) return take_frames();
    update_watches();
}

void Connection::all_is_sent() {
    if (state_ == State::ending) {
        // Closed at once, unread bytes of the other end would make the system throw away what it was sent
        // last.
        state_ = State::lingering;
        if (out_ || is_input_ended_ || ::shutdown(out(), SHUT_WR) != 0) return be_gone();
        last_taken_ = steady_seconds();
        update_watches();
        return arm_timer();
    }
    if (wants_turn_) schedule_turn();
    take_frames();
}

void Connection::ask_turn() {
    wants_turn_ = true;
    schedule_turn();
}

void Connection::schedule_turn() {
    if (queue_.empty() && turn_timer_ == 0)
        turn_timer_ = loop_.after(0, [this] {
            turn_timer_ = 0;
            run_turn();
        });
}

void Connection::run_turn() {
    // What was sent since it was asked for goes first.
    if (!queue_.empty()) return;
    if (state_ == State::ending) return all_is_sent();
    if (state_ != State::open) return;
    wants_turn_ = false;
    guarded([&] { session_->turn(); });
}

// ---- the end ----

void Connection::finish() {
    if (state_ != State::open) return;
    state_ = State::ending;
    last_taken_ = steady_seconds();
    schedule_turn();  // where nothing is queued; it goes later, since the session may have called this
    update_watches();
    arm_timer();
}

void Connection::drop(const std::string& why) {
    if (state_ != State::open) return;
    why_ = why;
    const std::vector<std::byte> last = session_->farewell(why);
    if (!last.empty()) send(last);
    finish();
}

void Connection::discard_input() {
    std::array<std::byte, kReadBytes> bytes;
    const ssize_t size = ::read(in_.get(), bytes.data(), bytes.size());
    if (size == 0 || (size < 0 && !is_no_failure())) be_gone();
}

void Connection::be_gone() {
    if (state_ == State::gone) return;
    state_ = State::gone;
    queue_.clear();
    queued_bytes_ = 0;
    loop_.unwatch(in_.get());
    loop_.unwatch(out());
    watched_in_ = watched_out_ = 0;
    for (EventLoop::TimerId* timer : {&timer_, &turn_timer_, &more_timer_})
        loop_.cancel(std::exchange(*timer, 0));
    // Whoever called this may still be at work in this object.
    timer_ = loop_.after(0, [this] { gone_(*this); });
}

// ---- watches and times ----

void Connection::watch(int fd, uint32_t events, uint32_t& watched) {
    if (events == watched) return;
    if (events == 0)
        loop_.unwatch(fd);
    else if (watched != 0)
        loop_.change(fd, events);
    else
        loop_.watch(fd, events, [this](uint32_t happened) { on_event(happened); });
    watched = events;
}

void Connection::update_watches() {
    if (state_ == State::gone) return;
    const bool is_taking =
        state_ == State::open && queued_bytes_ <= limits_.most_queued_bytes && more_timer_ == 0;
    const bool is_reading = !is_input_ended_ && (is_taking || state_ == State::lingering);
    const uint32_t in = is_reading ? uint32_t(EPOLLIN) : 0,
                   out_events = queue_.empty() ? 0 : uint32_t(EPOLLOUT);
    if (out_) {
        watch(in_.get(), in, watched_in_);
        watch(out_.get(), out_events, watched_out_);
    } else {
        watch(in_.get(), in | out_events, watched_in_);
    }
}

// The nearest of the times that are running; 0 where none is.
double Connection::deadline() const {
    if (state_ == State::lingering) return last_taken_ + kLingerSeconds;
    if (!queue_.empty() || state_ == State::ending) return last_taken_ + limits_.stall_s;
    double nearest = reader_.is_within() ? frame_begun_ + limits_.stall_s : 0;
    if (limits_.idle_s > 0 && (nearest == 0 || last_in_ + limits_.idle_s < nearest))
        nearest = last_in_ + limits_.idle_s;
    return nearest;
}

// The timer is not moved each time that its time moves on: it looks again when it fires.
void Connection::arm_timer() {
    const double until = deadline();
    if (state_ == State::gone || until == 0 || (timer_ != 0 && timer_at_ <= until)) return;
    loop_.cancel(timer_);
    timer_at_ = until;
    timer_ = loop_.after(until - steady_seconds(), [this] {
        timer_ = 0;
        check_time();
    });
}

void Connection::check_time() {
    const double until = deadline();
    if (until == 0 || steady_seconds() < until) return arm_timer();
    if (state_ == State::open && queue_.empty())
        return drop(
            core::text(reader_.is_within() ? "stopped within a message for %g s" : "said nothing for %g s",
                       reader_.is_within() ? limits_.stall_s : limits_.idle_s));
    if (state_ == State::open) why_ = "does not read what it is sent";
    be_gone();
}

}  // namespace net
