// One client of a server: frames in and out on an event loop, bounded in bytes and in time, whatever the
// other end does.
//
// Promises.  Nothing here waits.  At most a frame that is not whole, and limits.most_queued_bytes and what
// one frame or turn makes the session send, are held for a client.  A client that does not read is not read
// from either, and is dropped after limits.stall_s.  No client has more than limits.frames_a_turn frames done
// before the others have had theirs.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/descriptor.h"
#include "net/event_loop.h"
#include "net/frames.h"

namespace net {

struct ConnectionLimits {
    size_t most_frame_bytes = 64 << 10;    // body of a frame from the other end
    size_t most_queued_bytes = 256 << 10;  // beyond which nothing more is read from the other end
    double stall_s = 30;  // half a frame has come, or queued bytes are not taken, for so long
    double idle_s = 0;    // nothing at all has come for so long; 0: never
    int frames_a_turn = 16;
};

class Connection;

// What a server does for one client; made when it connects, destroyed when it is gone.  None of the functions
// is called from within a call of Connection's.
class Session {
  public:
    virtual ~Session() = default;
    // Throws core::Error where the frame is wrong or cannot be done: the client is dropped.
    virtual void received(std::span<const std::byte> body) = 0;
    // Called once for each Connection::ask_turn(), when the system has taken all that was queued and others
    // have had their turn: where a long answer is made piece by piece.  Throws like received().
    virtual void turn() {}
    // The other end will send nothing more.  By default the connection is finished.
    virtual void input_ended(Connection& connection);
    // What is to be said last to a client that is dropped; empty: nothing.
    virtual std::vector<std::byte> farewell(const std::string& /*why*/) { return {}; }
};

struct ConnectionCounts {
    uint64_t bytes_in = 0, bytes_out = 0, frames_in = 0, frames_out = 0;  // bytes with frame headers
};

// Not thread-safe.
class Connection {
  public:
    // Called once, when the connection is over.  It may destroy the connection.
    using Gone = std::function<void(Connection&)>;

    // A socket; or two ends of pipes, `in` to read from and `out` to write to.  They are made not to block.
    Connection(EventLoop& loop, core::Descriptor socket, const ConnectionLimits& limits, Gone gone);
    Connection(EventLoop& loop, core::Descriptor in, core::Descriptor out, const ConnectionLimits& limits,
               Gone gone);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    // Before the loop runs on.
    void start(std::unique_ptr<Session> session);

    // Sends what the system takes now and keeps the rest.  Nothing where the connection is ending.
    void send(std::span<const std::byte> body);
    size_t queued_bytes() const { return queued_bytes_; }

    // session.turn() will be called; asking again before that changes nothing.
    void ask_turn();

    // No more frames are taken; when all that is queued has been sent, the connection is over.
    void finish();
    // The same for a client that did wrong, after session.farewell().
    void drop(const std::string& why);

    // Why it was dropped, or is being; empty where it was not.
    const std::string& failure() const { return why_; }
    const ConnectionCounts& counts() const { return counts_; }

  private:
    enum class State { open, ending, lingering, gone };
    int out() const { return out_ ? out_.get() : in_.get(); }
    void on_event(uint32_t events);
    void read();
    void take_frames();
    void write();
    bool write_some();
    void all_is_sent();
    void schedule_turn();
    void run_turn();
    void update_watches();
    void watch(int fd, uint32_t events, uint32_t& watched);
    double deadline() const;
    void arm_timer();
    void check_time();
    void discard_input();
    void be_gone();
    template <class Work>
    void guarded(const Work& work);

    EventLoop& loop_;
    core::Descriptor in_, out_;  // out_ is empty where one socket is both
    ConnectionLimits limits_;
    Gone gone_;
    std::unique_ptr<Session> session_;
    State state_ = State::open;
    std::string why_;
    FrameReader reader_;
    std::deque<std::vector<std::byte>> queue_;
    size_t queued_bytes_ = 0, front_sent_ = 0;
    bool is_input_ended_ = false, wants_turn_ = false;
    uint32_t watched_in_ = 0, watched_out_ = 0;
    EventLoop::TimerId timer_ = 0, turn_timer_ = 0, more_timer_ = 0;
    // Steady seconds: when something came, when the first bytes of the frame that is not whole did, and when
    // the system took something last.
    double last_in_, frame_begun_, last_taken_, timer_at_ = 0;
    ConnectionCounts counts_;
};

}  // namespace net
