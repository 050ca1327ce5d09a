#include "net/server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <atomic>
#include <cstdlib>
#include <future>
#include <thread>

#include "net/address.h"
#include "net/frame_stream.h"
#include "net/socket_address.h"
#include "net/stop_signals.h"

namespace {

constexpr double kSoon = 20;  // seconds; waited only where something is wrong

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Echoes; "pour" is answered by frames without end, piece by piece; "bad" is wrong.
class Echo : public net::Session {
  public:
    explicit Echo(net::Connection& connection) : connection_(connection) {}
    void received(std::span<const std::byte> body) override {
        const std::string text = text_of(body);
        if (text == "bad") throw core::Error("that was bad");
        if (text == "pour") return connection_.ask_turn();
        connection_.send(body);
    }
    void turn() override {
        connection_.send(bytes_of(std::string(1000, 'x')));
        connection_.ask_turn();
    }
    std::vector<std::byte> farewell(const std::string& why) override {
        const std::string text = "dropped: " + why;
        return {bytes_of(text).begin(), bytes_of(text).end()};
    }

  private:
    net::Connection& connection_;
};

// The system may give a signal to any thread; those that were there before the server let it through.
TEST(StopSignals, ReachTheLoopFromThreadsThatWereThereBefore) {
    // The thread sanitizer lets signals through in few calls; this is one.
    std::atomic<bool> is_over = false;
    std::thread earlier([&] {
        while (!is_over) ::usleep(1000);
    });
    net::EventLoop loop;
    const net::StopSignals stop(loop);
    ::pthread_kill(earlier.native_handle(), SIGTERM);
    loop.run();  // else the signal has ended the program
    is_over = true;
    earlier.join();
}

class Serving : public ::testing::Test {
  protected:
    void serve(net::ServerLimits limits = {}, const std::string& where = "127.0.0.1:0") {
        std::promise<std::string> name;
        auto named = name.get_future();
        thread_ = std::thread([this, limits, where, &name] {
            net::EventLoop loop;
            net::StopSignals stop(loop);
            const std::string busy = "busy";
            net::Server server(loop, limits,
                               [](net::Connection& connection) { return std::make_unique<Echo>(connection); },
                               {bytes_of(busy).begin(), bytes_of(busy).end()});
            net::Listener listener(net::parse_address(where));
            const std::string at = listener.name();
            server.listen(std::move(listener));
            name.set_value(at);
            loop.run();
            counts_ = server.counts();
        });
        name_ = named.get();
    }
    // Twice, the server's counts are those of its end.
    net::ServerCounts stop() {
        if (thread_.joinable()) {
            ::pthread_kill(thread_.native_handle(), SIGTERM);
            thread_.join();
        }
        return counts_;
    }
    void TearDown() override { stop(); }

    core::Descriptor connect() const { return net::connect_to(net::parse_address(name_), kSoon); }
    net::FrameStream client() const { return {connect(), name_, 1 << 20}; }
    static std::string answer(net::FrameStream& client, const std::string& text) {
        client.send(bytes_of(text), kSoon);
        return text_of(client.receive(kSoon));
    }
    // Until the server closes.
    static void expect_closed(int socket) {
        pollfd waiting{socket, POLLIN, 0};
        char bytes[4096];
        ssize_t size = 1;
        while (size > 0) {
            ASSERT_GT(::poll(&waiting, 1, int(kSoon * 1000)), 0);
            size = ::read(socket, bytes, sizeof bytes);
        }
    }

    std::string name_;
    std::thread thread_;
    net::ServerCounts counts_;
};

TEST_F(Serving, AnswersManyClientsInTurn) {
    serve();
    std::vector<net::FrameStream> clients;
    for (int i = 0; i != 100; ++i) clients.push_back(client());
    for (int round = 0; round != 3; ++round)
        for (size_t i = 0; i != clients.size(); ++i)
            ASSERT_EQ(answer(clients[i], "hello " + std::to_string(i)), "hello " + std::to_string(i));
    clients.clear();
    net::FrameStream last = client();
    answer(last, "x");
    const net::ServerCounts counts = stop();
    EXPECT_EQ(counts.seen, 101u);
    EXPECT_EQ(counts.dropped, 0u);
    EXPECT_EQ(counts.traffic.frames_in, 301u);
    EXPECT_EQ(counts.traffic.bytes_in, counts.traffic.bytes_out);
}

TEST_F(Serving, ListensOnAUnixSocketOfItsUserAndRemovesIt) {
    char folder[] = "/tmp/net-test-XXXXXX";
    ASSERT_NE(::mkdtemp(folder), nullptr);
    const std::string path = std::string(folder) + "/socket";
    for (int round = 0; round != 2; ++round) {
        serve({}, path);
        EXPECT_EQ(name_, path);
        struct stat status = {};
        ASSERT_EQ(::stat(path.c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 0777, 0600u);
        net::FrameStream one = client();
        EXPECT_EQ(answer(one, "here"), "here");
        EXPECT_THROW(net::Listener{net::parse_address(path)}, core::Error) << "somebody listens there";
        stop();
        EXPECT_NE(::stat(path.c_str(), &status), 0);
        // One that is left over from a server that was killed is in nobody's way.
        if (round == 0) {
            const core::Descriptor left(::socket(AF_UNIX, SOCK_STREAM, 0));
            const net::SocketAddress address = net::unix_address(path);
            ASSERT_EQ(::bind(left.get(), address.get(), address.size), 0);
        }
    }
    ::rmdir(folder);
}

TEST_F(Serving, AClientThatDoesWrongIsToldWhyAndOthersDoNotNotice) {
    serve();
    net::FrameStream good = client(), bad = client();
    EXPECT_EQ(answer(bad, "bad"), "dropped: that was bad");
    EXPECT_THROW(bad.receive(kSoon), net::ConnectionLost);
    net::FrameStream liar = client();
    const core::Descriptor raw = connect();
    const uint32_t length = 0xfffffff0;
    ASSERT_EQ(::send(raw.get(), &length, sizeof length, 0), ssize_t(sizeof length));
    expect_closed(raw.get());
    EXPECT_EQ(answer(good, "still here"), "still here");
    EXPECT_EQ(stop().dropped, 2u);
}

TEST_F(Serving, HalfAMessageEndsAtTheStallTime) {
    net::ServerLimits limits;
    limits.connection.stall_s = 0.05;
    serve(limits);
    net::FrameStream good = client();
    const core::Descriptor raw = connect();
    ASSERT_EQ(::send(raw.get(), "\x10\0\0\0ab", 6, 0), 6);
    expect_closed(raw.get());
    EXPECT_EQ(answer(good, "still here"), "still here");
}

TEST_F(Serving, SilenceEndsAtTheIdleTimeWhereThereIsOne) {
    net::ServerLimits limits;
    limits.connection.idle_s = 0.05;
    serve(limits);
    const core::Descriptor raw = connect();
    expect_closed(raw.get());
}

// Both kinds of flood: requests whose answers are not read, and an answer that is not read.
TEST_F(Serving, AClientThatDoesNotReadIsNotReadFromAndThenDropped) {
    net::ServerLimits limits;
    limits.connection.stall_s = 0.2;
    limits.connection.most_queued_bytes = 10'000;
    serve(limits);
    net::FrameStream good = client();
    net::FrameStream flood = client(), pour = client();
    pour.send(bytes_of("pour"), kSoon);
    const std::string request(1000, 'r');
    try {
        for (int i = 0; i != 100'000; ++i) flood.send(bytes_of(request), kSoon);
    } catch (const net::ConnectionLost&) {
        // where it notices
    }
    EXPECT_EQ(answer(good, "still here"), "still here");
    EXPECT_THROW(while (!pour.receive(kSoon).empty())::poll(nullptr, 0, 1), net::ConnectionLost);
    const net::ServerCounts counts = stop();
    EXPECT_EQ(counts.dropped, 2u);
    EXPECT_LT(counts.traffic.bytes_in, 20'000'000u) << "of 100 MB";
}

TEST_F(Serving, OneClientTooManyIsTurnedAway) {
    net::ServerLimits limits;
    limits.most_connections = 2;
    serve(limits);
    net::FrameStream one = client(), two = client();
    answer(one, "1"), answer(two, "2");
    net::FrameStream three = client();
    EXPECT_EQ(text_of(three.receive(kSoon)), "busy");
    EXPECT_THROW(three.receive(kSoon), net::ConnectionLost);
    EXPECT_EQ(answer(one, "still here"), "still here");
    EXPECT_EQ(stop().refused, 1u);
}

TEST_F(Serving, AClientMaySayItsLastAndStillBeAnswered) {
    serve();
    const core::Descriptor raw = connect();
    ASSERT_EQ(::send(raw.get(), "\x2\0\0\0hi", 6, 0), 6);
    ASSERT_EQ(::shutdown(raw.get(), SHUT_WR), 0);
    std::string got;
    char bytes[64];
    pollfd waiting{raw.get(), POLLIN, 0};
    for (ssize_t size = 1; size > 0;) {
        ASSERT_GT(::poll(&waiting, 1, int(kSoon * 1000)), 0);
        size = ::read(raw.get(), bytes, sizeof bytes);
        if (size > 0) got.append(bytes, size_t(size));
    }
    EXPECT_EQ(got, std::string("\x2\0\0\0hi", 6));
    EXPECT_EQ(stop().dropped, 0u);
}

TEST(ServeOne, ServesTwoPipesUntilTheFirstEnds) {
    int to[2], from[2];
    ASSERT_EQ(::pipe2(to, O_CLOEXEC), 0);
    ASSERT_EQ(::pipe2(from, O_CLOEXEC), 0);
    std::thread server_thread([&] {
        net::EventLoop loop;
        net::Server server(loop, {},
                           [](net::Connection& connection) { return std::make_unique<Echo>(connection); });
        server.serve_one(core::Descriptor(to[0]), core::Descriptor(from[1]));
        loop.run();
    });
    {
        net::FrameStream client(core::Descriptor(from[0]), core::Descriptor(to[1]), "server", 1000);
        client.send(bytes_of("over pipes"), kSoon);
        EXPECT_EQ(text_of(client.receive(kSoon)), "over pipes");
    }
    server_thread.join();
}

TEST(ServeOne, RefusesFiles) {
    net::EventLoop loop;
    net::Server server(loop, {},
                       [](net::Connection& connection) { return std::make_unique<Echo>(connection); });
    EXPECT_THROW(
        server.serve_one(core::Descriptor(::open("/dev/null", O_RDONLY)), core::Descriptor(::dup(1))),
        core::Error);
}

TEST(Connecting, SaysThatNobodyListens) {
    const std::string name = net::Listener(net::parse_address("127.0.0.1:0")).name();
    EXPECT_THROW(net::connect_to(net::parse_address(name), 1), core::Error);
    EXPECT_THROW(net::connect_to(net::parse_address("/nowhere/socket"), 1), core::Error);
}

}  // namespace
