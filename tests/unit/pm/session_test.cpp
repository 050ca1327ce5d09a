// Clients and servers of progressive meshes over sockets: sessions that go on, and neighbours that do wrong.
#include <sys/socket.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <thread>

#include "net/stop_signals.h"
#include "pm/client.h"
#include "pm/follow.h"
#include "pm/server.h"
#include "streaming_link.h"

namespace {

using namespace pm_test;

constexpr double kSoon = 30;  // seconds; waited only where something is wrong

class Session : public ::testing::Test {
  protected:
    void SetUp() override {
        char name[] = "/tmp/pm-session-XXXXXX";
        ASSERT_NE(::mkdtemp(name), nullptr);
        folder_ = name;
        write("torus", splat_test::bumpy_torus(24, 60));
        write("ball", splat_test::icosphere(3));
    }
    void TearDown() override {
        stop();
        std::filesystem::remove_all(folder_);
    }
    void write(const std::string& name, const mesh::Mesh& mesh) const {
        core::OutputFile out(folder_ + "/" + name + ".pm");
        const Bytes bytes = build_bytes(mesh);
        out.write(bytes);
        out.commit();
    }
    void serve(pm::ServerOptions options = {}, const std::vector<std::string>& names = {"torus", "ball"}) {
        std::promise<void> ready;
        auto is_ready = ready.get_future();
        thread_ = std::thread([this, options, names, &ready] {
            net::EventLoop loop;
            net::StopSignals stop(loop);
            std::vector<pm::CatalogueEntry> catalogue;
            for (const std::string& name : names) catalogue.push_back({name, folder_ + "/" + name + ".pm"});
            pm::Server server(loop, catalogue, options);
            server.listen(net::Listener(net::parse_address(folder_ + "/socket")));
            ready.set_value();
            loop.run();
        });
        is_ready.wait();
    }
    void stop() {
        if (!thread_.joinable()) return;
        ::pthread_kill(thread_.native_handle(), SIGTERM);
        thread_.join();
    }
    net::FrameStream stream() const {
        return {net::connect_to(net::parse_address(folder_ + "/socket"), kSoon), "server",
                pm::kMostServerMessageBytes};
    }
    static void wait_for_all(pm::Client& client) {
        while (!client.is_complete()) ASSERT_TRUE(client.wait(kSoon));
    }
    core::Json status() const { return core::Json::parse(pm::Client(stream(), kSoon).status()); }
    pm::Model model(const std::string& name) const { return pm::Model(folder_ + "/" + name + ".pm"); }

    std::string folder_;
    std::thread thread_;
};

constexpr pm::Service kServices[] = {pm::Service::selective, pm::Service::one_way, pm::Service::lists};

TEST_F(Session, FetchesAWholeModelByEveryService) {
    serve();
    const pm::Model torus = model("torus");
    for (const pm::Service service : kServices) {
        pm::Client client(stream(), kSoon);
        client.open("torus", service);
        EXPECT_TRUE(client.look_at(pm::View(), pm::Culling::off));
        wait_for_all(client);
        EXPECT_EQ(client.refine().split_count(), torus.details());
        EXPECT_EQ(placed(pm::mesh_of(client.state().replica(), client.refine())),
                  placed(pm::mesh_of_level(torus, torus.details())));
        const uint64_t up = client.stream().bytes_sent(), down = client.stream().bytes_received();
        EXPECT_FALSE(client.look_at(pm::View(), pm::Culling::off));
        EXPECT_TRUE(client.is_complete());
        EXPECT_EQ(client.stream().bytes_sent(), up);
        EXPECT_EQ(client.stream().bytes_received(), down);
    }
}

// Cut after every k-th packet, also within one, and taken up again.
TEST_F(Session, GoesOnWhereItWasCut) {
    pm::ServerOptions options;
    options.packet_decisions = 40;
    serve(options);
    const pm::Model torus = model("torus");
    const std::tuple<uint64_t, pm::Service> cases[] = {
        {1, pm::Service::selective},  {2, pm::Service::selective}, {5, pm::Service::selective},
        {11, pm::Service::selective}, {2, pm::Service::one_way},   {3, pm::Service::lists}};
    for (const auto& [packets, service] : cases) {
        std::unique_ptr<pm::ClientState> state;
        uint64_t splits = 0;
        int connections = 0;
        for (bool is_done = false; !is_done; ++connections) {
            ASSERT_LT(connections, 1000);
            pm::Client client(stream(), kSoon);
            if (state)
                client.resume("torus", pm::ClientState::from_bytes(state->to_bytes(), "state"));
            else
                client.open("torus", service);
            is_done = !client.look_at(pm::View(), pm::Culling::off);
            while (!client.is_complete() && client.counts().packets < packets)
                ASSERT_TRUE(client.wait(kSoon));
            splits += client.counts().splits;
            state = std::make_unique<pm::ClientState>(client.take_state());
            is_done = is_done || state->replica().split_count() == torus.details();
        }
        EXPECT_EQ(splits, torus.details()) << "none is lost, none comes twice";
        EXPECT_EQ(state->replica().split_count(), torus.details());
    }
}

// What a client was told of splits that it cannot have is not in its record, so it asks again.
TEST_F(Session, AStateThatIsTakenOverForgetsWhatItsRecordDoesNotHold) {
    serve();
    const pm::ServedModel served(model("torus"));
    Random random(12);
    auto client = std::make_unique<pm::Client>(stream(), kSoon);
    client->open("torus");
    for (int i = 0; i != 40; ++i) {
        geom::Camera camera;
        const pm::Placement& at = served.model().header().placement;
        camera.eye =
            at.world_from_unit(glm::dvec3(0.5)) + random.direction() * at.extent * (0.2 + random.unit());
        camera.target = at.world_from_unit(glm::dvec3(0.5) + 0.3 * random.direction());
        camera.up = random.direction();
        client->look_at(pm::make_view(geom::make_view(camera, 200, 200), 0.5 + 4 * random.unit()));
        wait_for_all(*client);
        auto again = std::make_unique<pm::Client>(stream(), kSoon);
        again->resume("torus", client->take_state());
        client = std::move(again);
    }
    EXPECT_GT(client->state().replica().split_count(), 100u);
}

TEST_F(Session, GoesOnAtAServerThatWasRestartedButNotWithAnotherModel) {
    pm::ServerOptions options;
    options.packet_decisions = 40;
    serve(options);
    auto client = std::make_unique<pm::Client>(stream(), kSoon);
    client->open("torus");
    client->look_at(pm::View(), pm::Culling::off);
    ASSERT_TRUE(client->wait(kSoon));
    stop();
    EXPECT_THROW(while (true) client->wait(kSoon), net::ConnectionLost);
    const std::vector<std::byte> kept = client->take_state().to_bytes();
    const auto state = [&] { return pm::ClientState::from_bytes(kept, "state"); };
    serve(options);
    pm::Client again(stream(), kSoon);
    again.resume("torus", state());
    again.look_at(pm::View(), pm::Culling::off);
    wait_for_all(again);
    EXPECT_EQ(again.state().replica().split_count(), model("torus").details());
    try {
        pm::Client(stream(), kSoon).resume("ball", state());
        FAIL() << "the hash differs";
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("hash differs"), std::string::npos) << error.what();
    }
}

TEST_F(Session, ANewViewTakesThePlaceOfTheOneBefore) {
    pm::ServerOptions options;
    options.packet_decisions = 4;
    serve(options);
    pm::Client client(stream(), kSoon);
    client.open("torus");
    client.look_at(pm::View(), pm::Culling::off);
    pm::View coarse;
    coarse.eye = {0, 0, 30};
    coarse.forward = {0, 0, -1}, coarse.right = {1, 0, 0}, coarse.down = {0, -1, 0};
    coarse.tolerance = 0.001;
    client.look_at(coarse);
    wait_for_all(client);
    EXPECT_FALSE(pm::Sweep(client.state().replica(), coarse, client.state().header().placement).current() !=
                 pm::kNone);
    EXPECT_LT(client.state().replica().split_count(), model("torus").details());
}

TEST_F(Session, RepliesThatFitNothingAreRefusedAndOthersGoOn) {
    serve();
    pm::Client good(stream(), kSoon);
    good.open("ball");
    const auto refusal_of = [&](const std::vector<std::vector<std::byte>>& messages) {
        net::FrameStream bad = stream();
        std::string why;
        for (const auto& message : messages) bad.send(message, kSoon);
        try {
            for (;;) {
                const auto body = bad.receive(kSoon);
                if (body.empty()) return std::string("nothing");
                const pm::Reply reply = pm::parse_reply(body);
                if (reply.kind == pm::ReplyKind::failed) why = reply.text;
            }
        } catch (const net::ConnectionLost&) {
            return why;
        }
    };
    pm::Request view, open;
    view.kind = pm::RequestKind::view;
    open.name = "ball";
    EXPECT_NE(refusal_of({pm::to_bytes(view)}), "");
    view.number = 1;
    EXPECT_EQ(refusal_of({pm::to_bytes(view)}), "it sends a view before it has a model");
    EXPECT_EQ(refusal_of({pm::to_bytes(open), pm::to_bytes(view), pm::to_bytes(view)}),
              "its views are not numbered in turn");
    EXPECT_EQ(refusal_of({pm::to_bytes(open), pm::to_bytes(open)}),
              "it has a model already; connect again for another one");
    pm::Request list = view, by_lists = open;
    list.kind = pm::RequestKind::list;
    list.bytes = {std::byte{0xff}};
    EXPECT_EQ(refusal_of({pm::to_bytes(open), pm::to_bytes(list)}),
              "its service has lists in the place of views, or views in that of lists");
    by_lists.service = pm::Service::lists;
    EXPECT_EQ(refusal_of({pm::to_bytes(by_lists), pm::to_bytes(list), pm::to_bytes(list)}).substr(0, 22),
              "its views are not numb");
    open.name = "../ball";
    EXPECT_EQ(refusal_of({pm::to_bytes(open)}), "'../ball' is not in the catalogue");
    view.view.eye.x = std::nan("");
    EXPECT_EQ(refusal_of({pm::to_bytes(view)}), "view: a value is not finite");
    EXPECT_EQ(refusal_of({{std::byte{77}}}), "request: its kind is unknown");
    pm::Request resume;
    resume.kind = pm::RequestKind::resume;
    resume.name = "ball";
    resume.hash = model("ball").hash();
    Random random(5);
    for (int i = 0; i != 20; ++i) {
        resume.service = kServices[i % 3];
        resume.bytes.resize(1 + random.bits() % 50);
        for (std::byte& byte : resume.bytes) byte = std::byte(random.bits());
        refusal_of({pm::to_bytes(resume), {std::byte{77}}});
    }
    good.look_at(pm::View(), pm::Culling::off);
    wait_for_all(good);
    EXPECT_EQ(good.state().replica().split_count(), model("ball").details());
}

// One that never reads, one that floods with views, and one that sends half a message.
TEST_F(Session, NeighboursThatDoNotReadSlowNobody) {
    pm::ServerOptions options;
    options.limits.connection.stall_s = 0.3;
    serve(options);
    net::FrameStream deaf = stream(), flood = stream();
    const core::Descriptor half = net::connect_to(net::parse_address(folder_ + "/socket"), kSoon);
    ASSERT_EQ(::send(half.get(), "\x10\0\0\0ab", 6, 0), 6);
    pm::Request open, view;
    open.name = "torus";
    view.kind = pm::RequestKind::view;
    view.culling = pm::Culling::off;
    deaf.send(pm::to_bytes(open), kSoon);
    flood.send(pm::to_bytes(open), kSoon);
    try {
        for (view.number = 1; view.number != 20'000; ++view.number) flood.send(pm::to_bytes(view), kSoon);
    } catch (const core::Error&) {
        // dropped, since it does not read
    }
    view.number = 1;
    deaf.send(pm::to_bytes(view), kSoon);
    pm::Client good(stream(), kSoon);
    good.open("torus");
    good.look_at(pm::View(), pm::Culling::off);
    wait_for_all(good);
    EXPECT_EQ(good.state().replica().split_count(), model("torus").details());
}

// More clients than there are answers at a time: each begins again and again; nobody notices.
TEST_F(Session, ManyClientsTakeTurnsAtFewAnswers) {
    pm::ServerOptions options;
    options.packet_decisions = 100;
    serve(options);
    std::vector<std::unique_ptr<pm::Client>> clients;
    for (size_t i = 0; i != 3 * pm::kMostUnfinished; ++i) {
        clients.push_back(std::make_unique<pm::Client>(stream(), kSoon));
        clients.back()->open("torus");
        clients.back()->look_at(pm::View(), pm::Culling::off);
    }
    for (auto& client : clients) wait_for_all(*client);
    for (auto& client : clients) EXPECT_EQ(client->state().replica().split_count(), model("torus").details());
    const core::Json json = status();
    EXPECT_EQ(json["sessions_opened"], clients.size());
    EXPECT_EQ(json["splits_sent"], clients.size() * uint64_t(model("torus").details()));
}

// A server that says anything whatever makes errors of the client, and nothing else.
TEST_F(Session, AHostileServerIsAnError) {
    const net::Listener listener(net::parse_address(folder_ + "/hostile"));
    const pm::Model ball = model("ball");
    const pm::ServedModel served(model("ball"));
    pm::Reply opened;
    opened.kind = pm::ReplyKind::opened;
    opened.header = pm::encode_header(ball.header());
    opened.bytes.assign(served.base_packet().begin(), served.base_packet().end());
    Random random(6);
    for (int i = 0; i != 60; ++i) {
        pm::Client client(net::FrameStream(net::connect_to(net::parse_address(folder_ + "/hostile"), kSoon),
                                           "hostile", pm::kMostServerMessageBytes),
                          kSoon);
        core::Descriptor at_server;
        while (!at_server) at_server.reset(::accept4(listener.descriptor(), nullptr, nullptr, 0));
        std::vector<std::byte> said = pm::to_bytes(opened);
        if (i % 2 == 0) said[random.bits() % said.size()] ^= std::byte(1 + random.bits() % 255);
        if (i % 6 == 0) said.resize(1 + random.bits() % said.size());
        net::FrameStream server(std::move(at_server), "server", 4096);
        server.send(said, kSoon);
        pm::Reply packet;
        packet.kind = pm::ReplyKind::packet;
        packet.view = 1;
        packet.is_first = true;
        packet.decisions = 100;
        packet.bytes.resize(200);
        for (std::byte& byte : packet.bytes) byte = std::byte(random.bits());
        server.send(pm::to_bytes(packet), kSoon);
        EXPECT_THROW(
            {
                client.open("ball");
                client.look_at(pm::View(), pm::Culling::off);
                wait_for_all(client);
            },
            core::Error);
    }
}

TEST_F(Session, AFollowerTakesUpALostConnection) {
    serve();
    pm::FollowOptions options;
    options.culling = pm::Culling::off;
    options.threshold_px = 0;
    options.timeout_s = kSoon;
    std::atomic<int> connections = 0;
    pm::Follower follower(
        [&] {
            ++connections;
            return stream();
        },
        "ball", options);
    stop();
    std::thread later([&] { serve(); });
    const pm::FrameCosts costs = follower.show(0, geom::Camera());
    later.join();
    EXPECT_TRUE(costs.is_complete);
    EXPECT_EQ(costs.splits, model("ball").details());
    EXPECT_GE(costs.resumed, 1u);
}

}  // namespace
