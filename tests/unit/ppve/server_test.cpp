#include "ppve/server.h"

#include <gtest/gtest.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <thread>

#include "net/address.h"
#include "net/frame_stream.h"
#include "ppve/sample/raster_sampler.h"
#include "ppve/status.h"
#include "scenes.h"

namespace {

using namespace ppve;

constexpr double kPatience = 60;  // seconds, for a machine that has much to do

// A server at a port of its own, in a thread.
class PpveServer : public testing::Test {
  protected:
    PpveServer() : sampler_(Clusters(ppve_test::ball(40, 1))) {
        ServerOptions options;
        options.scene = "ball";
        options.server.most_connections = 3;
        options.server.connection.most_frame_bytes = kMostRequestBytes;
        options.server.connection.stall_s = 1;
        server_.emplace(loop_, sampler_, options, [this](const AnswerReport&) { ++answers_; });
        net::Listener listener(net::parse_address("127.0.0.1:0"));
        address_ = listener.name();
        server_->connections().listen(std::move(listener));
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, wake_), 0);
        loop_.watch(wake_[0], EPOLLIN, [this](uint32_t) { loop_.stop(); });
        thread_ = std::thread([this] { loop_.run(); });
    }
    ~PpveServer() override {
        EXPECT_EQ(::write(wake_[1], "x", 1), 1);
        thread_.join();
        ::close(wake_[0]), ::close(wake_[1]);
    }

    net::FrameStream connect() {
        return {net::connect_to(net::parse_address(address_), kPatience), "server", size_t(1) << 28};
    }
    static Message receive(net::FrameStream& stream) { return parse(stream.receive(kPatience), "server"); }
    static Request request(uint64_t id) {
        Request r;
        r.id = id;
        r.frustum = ppve_test::looking_from({0, 0, 3}, {0, 0, 0}, 64, 48);
        return r;
    }

    RasterSampler sampler_;
    net::EventLoop loop_;
    std::optional<Server> server_;
    std::string address_;
    int wake_[2] = {};
    std::thread thread_;
    int answers_ = 0;
};

TEST_F(PpveServer, WelcomesAndAnswers) {
    auto stream = connect();
    EXPECT_EQ(std::get<Welcome>(receive(stream)).scene, "ball");
    for (uint64_t id = 1; id < 4; ++id) {
        stream.send(format(request(id)), kPatience);
        const auto answer = std::get<Answer>(receive(stream));
        EXPECT_EQ(answer.id, id);
        EXPECT_EQ(image_of(answer).samples() > 0, id == 1);
    }
}

TEST_F(PpveServer, CountsWhatItDoes) {
    auto stream = connect();
    receive(stream);
    Request huge = request(1);
    huge.frustum.view.width = huge.frustum.view.height = int(kMostSide);
    stream.send(format(huge), kPatience);
    EXPECT_EQ(std::get<Refusal>(receive(stream)).id, 1u);
    uint64_t sent = 0, samples = 0;
    for (uint64_t id = 2; id < 5; ++id) {
        stream.send(format(request(id)), kPatience);
        const auto answer = std::get<Answer>(receive(stream));
        sent += image_of(answer).samples(), samples += answer.samples;
    }
    const core::Json counters = core::Json::parse(ask_status(address_, kPatience));
    EXPECT_EQ(counters["clients"], 2);
    EXPECT_EQ(counters["requests"], 4);
    EXPECT_EQ(counters["requests_refused"], 1);
    EXPECT_EQ(counters["updates"], 3);
    EXPECT_EQ(counters["samples"], samples);
    EXPECT_EQ(counters["samples_kept"], sent);
    EXPECT_EQ(counters["session_points"], sent);
    EXPECT_GT(counters["session_bytes"], sent * 16);
    EXPECT_GT(counters["bytes_out"], counters["image_bytes"]);
    EXPECT_LE(counters["scene_bytes_touched_most"], counters["scene_bytes"]);
    EXPECT_EQ(counters["scene_bytes_touched"], 3 * uint64_t(counters["scene_bytes_touched_most"]));
    EXPECT_GT(counters["scene_bytes_touched"], 0);
}

TEST_F(PpveServer, TwoWhoAskAtOnceAreAnsweredInTurns) {
    auto a = connect(), b = connect();
    receive(a), receive(b);
    for (uint64_t id = 1; id < 4; ++id) {
        a.send(format(request(id)), kPatience), b.send(format(request(id)), kPatience);
        EXPECT_EQ(std::get<Answer>(receive(a)).octree_checksum, std::get<Answer>(receive(b)).octree_checksum);
    }
}

TEST_F(PpveServer, AClientOfGarbageIsToldWhyAndOthersGoOn) {
    auto good = connect(), bad = connect();
    receive(good), receive(bad);
    bad.send(std::vector<std::byte>(100, std::byte{7}), kPatience);
    EXPECT_EQ(std::get<Refusal>(receive(bad)).id, 0u);
    EXPECT_THROW(bad.receive(kPatience), core::Error);
    // Half a message, and gone.
    {
        auto half = connect();
        receive(half);
        const core::Descriptor raw = net::connect_to(net::parse_address(address_), kPatience);
        EXPECT_EQ(::write(raw.get(), "\xff\x00\x00\x00half", 8), 8);
    }
    good.send(format(request(1)), kPatience);
    EXPECT_EQ(std::get<Answer>(receive(good)).id, 1u);
}

TEST_F(PpveServer, ALengthThatIsAbsurdIsRefusedAtOnce) {
    auto stream = connect();
    receive(stream);
    core::Descriptor raw = net::connect_to(net::parse_address(address_), kPatience);
    EXPECT_EQ(::write(raw.get(), "\xff\xff\xff\xff", 4), 4);
    net::FrameStream rest(std::move(raw), "server", 1 << 20);
    receive(rest);
    EXPECT_EQ(std::get<Refusal>(receive(rest)).id, 0u);
}

TEST_F(PpveServer, OneClientTooManyIsToldSo) {
    auto a = connect(), b = connect(), c = connect();
    receive(a), receive(b), receive(c);
    auto d = connect();
    EXPECT_NE(std::get<Refusal>(receive(d)).reason.find("as many clients"), std::string::npos);
}

TEST_F(PpveServer, AClientThatNeverReadsHoldsNobodyUp) {
    auto deaf = connect();
    Request huge = request(1);
    huge.frustum = ppve_test::looking_from({0, 0, 2.2}, {0, 0, 0}, 1400, 1000);
    huge.codec = Codec::lzw, huge.elimination = Elimination::none;
    for (uint64_t id = 1; id < 4; ++id) huge.id = id, deaf.send(format(huge), kPatience);
    auto good = connect();
    receive(good);
    for (uint64_t id = 1; id < 4; ++id) {
        good.send(format(request(id)), kPatience);
        EXPECT_EQ(std::get<Answer>(receive(good)).id, id);
    }
}

}  // namespace
