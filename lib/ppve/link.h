// The way to a server, whole messages at a time: a socket, a command's pipes, or a recorded session.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ppve {

// Not thread-safe.
class Link {
  public:
    virtual ~Link() = default;
    // Waits at most `timeout_s` until the system has taken it.  Throws core::Error where the server is gone.
    virtual void send(std::span<const std::byte> message, double timeout_s) = 0;
    // The next message; empty where none is whole within `timeout_s`.  Throws core::Error where the server is
    // gone, or what it sends is no message.
    virtual std::vector<std::byte> receive(double timeout_s) = 0;
    // Nothing will come any more, and nothing is wrong.
    virtual bool is_over() const { return false; }
};

// "ppve://HOST:PORT" or "ppve:PATH" of a Unix socket.
bool is_server_address(const std::string& word);
// Throws core::UsageError for an address that is none, core::Error where nobody answers.
std::unique_ptr<Link> connect_to_server(const std::string& address, double timeout_s);

// Runs `sh -c COMMAND`, a server on its standard input and output; what it says on standard error goes to
// ours. Ends it by closing its input, and where that does not help by SIGTERM.
std::unique_ptr<Link> start_command(const std::string& command);

// Writes all that passes over a link to a file, ppve-session(5), which is whole when the link is destroyed.
class Recorder {
  public:
    explicit Recorder(const std::string& path);
    ~Recorder();
    void note(bool is_received, std::span<const std::byte> message);
    void commit();  // throws core::Error

  private:
    struct State;
    std::unique_ptr<State> state_;
};
std::unique_ptr<Link> recorded(std::unique_ptr<Link> link, Recorder& recorder);

// A session from its file: its first message comes at once, each other one after something was sent, whatever
// that is.  Then it is over.  Throws core::Error for a file that is none, or is cut off.
bool is_session_file(const std::string& path);
std::unique_ptr<Link> replay(const std::string& path);

}  // namespace ppve
