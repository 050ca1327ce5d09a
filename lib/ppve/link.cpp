#include "ppve/link.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "core/bytes.h"
#include "core/descriptor.h"
#include "core/error.h"
#include "core/file.h"
#include "net/address.h"
#include "net/frame_stream.h"
#include "ppve/messages.h"

extern char** environ;

namespace ppve {

using core::text;

namespace {

constexpr std::string_view kScheme = "ppve:";
constexpr std::array<char, 8> kMagic = {'p', 'p', 'v', 'e', '-', 's', 'e', 's'};
constexpr uint32_t kVersion = 1;

class StreamLink : public Link {
  public:
    explicit StreamLink(net::FrameStream stream) : stream_(std::move(stream)) {}
    void send(std::span<const std::byte> message, double timeout_s) override {
        stream_.send(message, timeout_s);
    }
    std::vector<std::byte> receive(double timeout_s) override {
        const auto body = stream_.receive(timeout_s);
        return {body.begin(), body.end()};
    }

  private:
    net::FrameStream stream_;
};

struct Pipe {
    core::Descriptor read, write;
};

Pipe make_pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw core::Error(text("pipe: %s", std::strerror(errno)));
    return {core::Descriptor(ends[0]), core::Descriptor(ends[1])};
}

// A child of ours, until it has ended.
class Child {
  public:
    Child(const std::string& command, const Pipe& input, const Pipe& output) {
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, input.read.get(), STDIN_FILENO);
        posix_spawn_file_actions_adddup2(&actions, output.write.get(), STDOUT_FILENO);
        std::string shell = "sh", option = "-c", line = command;
        char* const words[] = {shell.data(), option.data(), line.data(), nullptr};
        const int error = posix_spawn(&pid_, "/bin/sh", &actions, nullptr, words, environ);
        posix_spawn_file_actions_destroy(&actions);
        if (error != 0) throw core::Error(text("%s: %s", command.c_str(), std::strerror(error)));
    }
    Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
    // How it ended, which it is about to do or has done; empty where it does not.
    std::string ending() {
        for (int k = 0; k < 100 && pid_ > 0; ++k) {
            int status = 0;
            if (waitpid(pid_, &status, WNOHANG) == pid_) {
                pid_ = 0;
                return WIFEXITED(status) ? text("; the command ended with status %d", WEXITSTATUS(status))
                                         : text("; the command ended by signal %d", WTERMSIG(status));
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return {};
    }
    // Its pipes have been closed.
    ~Child() {
        if (pid_ <= 0) return;
        for (int k = 0; k < 100; ++k) {
            if (waitpid(pid_, nullptr, WNOHANG) != 0) return;
            if (k == 50) kill(pid_, SIGTERM);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }

  private:
    pid_t pid_ = 0;
};

class CommandLink : public Link {
  public:
    CommandLink(Child child, net::FrameStream stream)
        : child_(std::move(child)), link_(std::make_unique<StreamLink>(std::move(stream))) {}
    void send(std::span<const std::byte> message, double timeout_s) override {
        link_->send(message, timeout_s);
    }
    std::vector<std::byte> receive(double timeout_s) override {
        try {
            return link_->receive(timeout_s);
        } catch (const net::ConnectionLost& lost) {
            throw net::ConnectionLost(lost.what() + child_.ending());
        }
    }

  private:
    Child child_;  // destroyed after the pipes to it
    std::unique_ptr<Link> link_;
};

class RecordedLink : public Link {
  public:
    RecordedLink(std::unique_ptr<Link> link, Recorder& recorder)
        : link_(std::move(link)), recorder_(recorder) {}
    void send(std::span<const std::byte> message, double timeout_s) override {
        link_->send(message, timeout_s);
        recorder_.note(false, message);
    }
    std::vector<std::byte> receive(double timeout_s) override {
        std::vector<std::byte> message = link_->receive(timeout_s);
        if (!message.empty()) recorder_.note(true, message);
        return message;
    }
    bool is_over() const override { return link_->is_over(); }

  private:
    std::unique_ptr<Link> link_;
    Recorder& recorder_;
};

class ReplayLink : public Link {
  public:
    explicit ReplayLink(const std::string& path) : file_(path), reader_(file_.bytes(), file_.name()) {
        for (const char c : kMagic)
            if (reader_.take<char>() != c) throw core::Error(file_.name() + ": is no recorded session");
        if (const auto version = reader_.take<uint32_t>(); version != kVersion)
            throw core::Error(text("%s: session version %u, this program reads %u", file_.name().c_str(),
                                   version, kVersion));
        find_next();
    }
    void send(std::span<const std::byte>, double) override { may_give_ = true; }
    std::vector<std::byte> receive(double) override {
        if (!may_give_ || next_.empty()) return {};
        may_give_ = false;
        const std::vector<std::byte> message(next_.begin(), next_.end());
        find_next();
        return message;
    }
    bool is_over() const override { return next_.empty(); }

  private:
    void find_next() {
        next_ = {};
        while (next_.empty() && reader_.position() < file_.bytes().size()) {
            const auto kind = reader_.take<uint8_t>();
            reader_.take<double>();
            const auto size = reader_.take<uint32_t>();
            if (kind > 1 || size == 0 || size > file_.bytes().size() - reader_.position())
                throw core::Error(
                    text("%s: cut off or damaged at byte %zu", file_.name().c_str(), reader_.position()));
            const auto message = file_.bytes().subspan(reader_.position(), size);
            for (uint32_t k = 0; k < size; ++k) reader_.take<std::byte>();
            if (kind == 1) next_ = message;
        }
    }

    core::InputFile file_;
    core::ByteReader reader_;
    std::span<const std::byte> next_{};
    bool may_give_ = true;  // the server speaks first
};

}  // namespace

struct Recorder::State {
    explicit State(const std::string& path) : file(path) {}
    core::OutputFile file;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

Recorder::Recorder(const std::string& path) : state_(std::make_unique<State>(path)) {
    state_->file.write(kMagic.data(), kMagic.size());
    state_->file.write(&kVersion, sizeof kVersion);
}
Recorder::~Recorder() = default;

void Recorder::note(bool is_received, std::span<const std::byte> message) {
    core::ByteWriter head;
    head.put(static_cast<uint8_t>(is_received));
    head.put(std::chrono::duration<double>(std::chrono::steady_clock::now() - state_->start).count());
    head.put(static_cast<uint32_t>(message.size()));
    state_->file.write(head.bytes);
    state_->file.write(message);
}

void Recorder::commit() {
    state_->file.commit();
}

bool is_server_address(const std::string& word) {
    return word.starts_with(kScheme);
}

std::unique_ptr<Link> connect_to_server(const std::string& address, double timeout_s) {
    std::string place = address.substr(kScheme.size());
    if (place.starts_with("//")) place = place.substr(2);
    return std::make_unique<StreamLink>(
        net::FrameStream(net::connect_to(net::parse_address(place), timeout_s), address, kMostMessageBytes));
}

std::unique_ptr<Link> start_command(const std::string& command) {
    Pipe input = make_pipe(), output = make_pipe();
    Child child(command, input, output);
    net::FrameStream stream(std::move(output.read), std::move(input.write), command, kMostMessageBytes);
    return std::make_unique<CommandLink>(std::move(child), std::move(stream));
}

std::unique_ptr<Link> recorded(std::unique_ptr<Link> link, Recorder& recorder) {
    return std::make_unique<RecordedLink>(std::move(link), recorder);
}

bool is_session_file(const std::string& path) {
    return path.ends_with(".ppve");
}

std::unique_ptr<Link> replay(const std::string& path) {
    return std::make_unique<ReplayLink>(path);
}

}  // namespace ppve
