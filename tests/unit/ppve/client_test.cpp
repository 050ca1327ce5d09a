#include "ppve/client.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "ball_server.h"
#include "ppve/client/point_cache.h"

namespace {

using namespace ppve;

constexpr int kWidth = 120, kHeight = 90;

Gaze gaze_at(double angle, double time_s, bool is_still = true, bool is_stereo = false) {
    Gaze gaze;
    gaze.time_s = time_s;
    gaze.camera = {{4 * std::sin(angle), 0.8, 4 * std::cos(angle)}, {0, 0, 0}, {0, 1, 0}, 40};
    gaze.is_still = is_still;
    const geom::View middle = geom::make_view(gaze.camera, kWidth, kHeight);
    if (is_stereo)
        gaze.eyes = {geom::moved_aside(middle, -0.07, 4), geom::moved_aside(middle, 0.07, 4)};
    else
        gaze.eyes = {middle};
    return gaze;
}

ClientOptions small() {
    ClientOptions options;
    options.width = 80, options.height = 60;
    options.answer_timeout_s = 20;
    return options;
}

Client::OpenLink open(test::Faults& faults) {
    return [&faults] { return std::make_unique<test::BallServer>(faults); };
}

render::Frame draw(Client& client, const Gaze& gaze) {
    Reconstruction reconstruction;
    ReconstructionOptions options;
    options.look.shade = render::Shade::flat;
    std::vector<render::Frame> frames(gaze.eyes.size());
    std::vector<uint8_t> seen;
    const auto model = client.model();
    reconstruction.draw(*model, gaze.eyes, options, frames, &seen);
    client.note_drawn(*model, seen);
    return frames.back();
}

// Of the pixels that show a surface, those that are empty or of another colour.
double wrong_share(const render::Frame& frame, const geom::View& view) {
    const DepthImage exact = test::sample({view, Projection::perspective});
    double wrong = 0, covered = 0;
    for (size_t i = 0; i < exact.pixels(); ++i) {
        if (exact.depth[i] == 0) continue;
        ++covered;
        for (size_t c = 0; c < 3; ++c)
            if (std::abs(int(frame.rgb[3 * i + c]) - int(exact.colour[i] >> 8 * c & 0xff)) > 40) {
                ++wrong;
                break;
            }
    }
    return wrong / covered;
}

TEST(Client, AtRestHasThePictureItself) {
    test::Faults faults;
    Client client(open(faults), small());
    for (int k = 0; k < 6; ++k) {
        const Gaze gaze = gaze_at(0.3 * k, k);
        client.look(gaze);
        client.wait_until_settled();
        EXPECT_LT(wrong_share(draw(client, gaze), gaze.eyes[0]), 0.02) << k;
    }
    const ClientCounts counts = client.counts();
    EXPECT_EQ(counts.updates, 6u);
    EXPECT_EQ(counts.out_of_step, 0u);
    EXPECT_LT(counts.samples_kept, counts.samples * 2 / 3);
}

TEST(Client, BothEyesAreComplete) {
    test::Faults faults;
    Client client(open(faults), small());
    const Gaze gaze = gaze_at(0.2, 0, true, true);
    client.look(gaze);
    client.wait_until_settled();
    EXPECT_EQ(client.counts().updates, 2u);
    EXPECT_LT(wrong_share(draw(client, gaze), gaze.eyes[1]), 0.02);
}

TEST(Client, AsksOnceForAMovingEyeAndAtRestForThePictureAndWhatSurroundsIt) {
    test::Faults faults;
    ClientOptions options = small();
    Client client(open(faults), options);
    Gaze gaze = gaze_at(0, 0, false);
    for (int k = 0; k < 10; ++k) {
        gaze = gaze_at(0.02 * k, 0.05 * k, false);
        client.look(gaze);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_FALSE(client.is_settled());
    gaze.time_s = 1;
    client.look(gaze);
    client.wait_until_settled();
    for (int k = 0; k < 1000 && client.counts().updates_at_rest < 2; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(client.counts().updates_at_rest, 2u);
    EXPECT_LE(faults.requests, 13u);
    const uint64_t requests = faults.requests;
    for (int k = 0; k < 10; ++k) {
        gaze.time_s += 0.1;
        client.look(gaze);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    EXPECT_EQ(faults.requests, requests) << "an eye that rests asks for nothing";
}

TEST(Client, NeverWaitsForASilentServer) {
    test::Faults faults;
    faults.is_silent = true;
    const auto start = std::chrono::steady_clock::now();
    {
        Client client(open(faults), small());
        for (int k = 0; k < 50; ++k) {
            const Gaze gaze = gaze_at(0.02 * k, 0.01 * k, false);
            client.look(gaze);
            draw(client, gaze);
        }
        EXPECT_FALSE(client.is_settled());
    }
    // The end, too.  A wait for the server's time-out would be 20 s.
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(Client, OutOfStepIsNoticedAndMended) {
    test::Faults faults;
    faults.lost_at = 3;
    Client client(open(faults), small());
    for (int k = 0; k < 6; ++k) {
        const Gaze gaze = gaze_at(0.3 * k, k);
        client.look(gaze);
        client.wait_until_settled();
        EXPECT_LT(wrong_share(draw(client, gaze), gaze.eyes[0]), 0.02) << k;
    }
    EXPECT_EQ(client.counts().out_of_step, 1u);
    EXPECT_EQ(faults.started_anew, 1u);
    EXPECT_EQ(faults.connections, 1u);
}

TEST(Client, KeepsItsPointsWhenTheServerIsKilledAndConnectsAgain) {
    test::Faults faults;
    faults.killed_at = 2;
    Client client(open(faults), small());
    Gaze gaze = gaze_at(0, 0);
    client.look(gaze);
    client.wait_until_settled();
    const auto before = client.model();
    client.look(gaze_at(0.5, 1));
    client.wait_until_settled();
    EXPECT_FALSE(before->clusters.empty());
    EXPECT_EQ(faults.connections, 2u);
    EXPECT_EQ(client.counts().failures, 1u);
    gaze = gaze_at(0.5, 1);
    EXPECT_LT(wrong_share(draw(client, gaze), gaze.eyes[0]), 0.02);
}

TEST(Client, GarbageEndsTheConnectionNotTheClient) {
    test::Faults faults;
    faults.garbage_at = 1;
    Client client(open(faults), small());
    client.look(gaze_at(0, 0));
    client.wait_until_settled();
    EXPECT_EQ(faults.connections, 2u);
    EXPECT_EQ(client.counts().updates, 1u);
}

TEST(Client, SaysWhyThereIsNoPicture) {
    test::Faults faults;
    faults.refuses = true;
    Client refused(open(faults), small());
    refused.look(gaze_at(0, 0));
    try {
        refused.wait_until_settled();
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(), "server: busy");
    }
    faults.cannot_connect = true;
    Client alone(open(faults), small());
    alone.look(gaze_at(0, 0));
    EXPECT_THROW(alone.wait_until_settled(), core::Error);
}

TEST(Client, ASessionReplaysToTheSamePicture) {
    const std::string path = testing::TempDir() + "client_test.ppve";
    render::Frame recorded_frame;
    {
        test::Faults faults;
        Recorder recorder(path);
        {
            Client client([&] { return recorded(std::make_unique<test::BallServer>(faults), recorder); },
                          small());
            for (int k = 0; k < 3; ++k) {
                client.look(gaze_at(0.3 * k, k));
                client.wait_until_settled();
            }
            recorded_frame = draw(client, gaze_at(0.6, 2));
        }
        recorder.commit();
    }
    Client client([&] { return replay(path); }, small());
    for (int k = 0; k < 3; ++k) {
        client.look(gaze_at(0.3 * k, k));
        client.wait_until_settled();
    }
    const render::Frame again = draw(client, gaze_at(0.6, 2));
    EXPECT_EQ(again.rgb, recorded_frame.rgb);
    EXPECT_EQ(again.depth, recorded_frame.depth);
    // It is over: nothing more comes, and nobody waits for it.
    client.look(gaze_at(2, 3));
    client.wait_until_settled();
    EXPECT_EQ(client.counts().updates, 3u);
    std::remove(path.c_str());
}

// The client without its thread, so that ten thousand updates take a second.
TEST(PointCache, KeepsToItsMemoryForTenThousandUpdates) {
    test::Faults faults;
    test::BallServer server(faults);
    server.receive(0);
    PointCache cache(shape_around(test::scene_bounds()));
    constexpr uint64_t kMostBytes = 400'000;
    uint64_t most = 0, deleted = 0;
    for (uint64_t update = 1; update <= 10'000; ++update) {
        Request request;
        request.id = update;
        const double angle = 0.37 * double(update);
        request.frustum = test::frustum_at(
            {4 * std::sin(angle), 0.5 + 0.4 * std::sin(3 * angle), 4 * std::cos(angle)}, {0, 0, 0}, 24, 18);
        request.last_answer = cache.last_answer();
        request.octree_checksum = cache.tree().checksum();
        request.deletions = cache.obsolete(double(update), 200, kMostBytes);
        deleted += request.deletions.size();
        server.send(format(request), 1);
        const Message message = parse(server.receive(1), "server");
        ASSERT_TRUE(cache.take_in(std::get<Answer>(message), double(update)).is_in_step) << update;
        most = std::max(most, cache.bytes());
    }
    EXPECT_LE(most, kMostBytes);
    EXPECT_GT(deleted, 10u);
    EXPECT_EQ(faults.started_anew, 0u);
}

TEST(PointCache, WhatIsNotDrawnForLongestGoesFirst) {
    test::Faults faults;
    test::BallServer server(faults);
    server.receive(0);
    PointCache cache(shape_around(test::scene_bounds()));
    for (uint64_t update = 1; update <= 2; ++update) {
        Request request;
        request.id = update;
        request.frustum = test::frustum_at({update == 1 ? -4.0 : 4.0, 1, 0}, {0, 0, 0}, 300, 200);
        request.octree_checksum = cache.tree().checksum();
        server.send(format(request), 1);
        cache.take_in(std::get<Answer>(parse(server.receive(1), "server")), double(update));
    }
    const auto model = cache.model();
    std::vector<uint8_t> seen(model->clusters.size(), 1);
    seen[0] = 0;
    cache.note_drawn(*model, seen, 100);
    EXPECT_EQ(cache.obsolete(100, 50, 1 << 30), std::vector<uint64_t>{model->clusters[0]->id});
    EXPECT_TRUE(cache.obsolete(100, 1000, 1 << 30).empty());
    EXPECT_EQ(cache.obsolete(100, 1000, cache.bytes()).front(), model->clusters[0]->id);
}

}  // namespace
