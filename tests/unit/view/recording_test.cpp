#include "view/recording.h"

#include <gtest/gtest.h>

#include "cameras.h"

namespace {

TEST(Recording, HasACameraForEachThirtiethHoweverUnevenlyItIsTold) {
    std::mt19937_64 random(1);
    view::Recording recording(10);
    for (const double time_s : {10.0, 10.01, 10.5, 10.52, 11.0})
        recording.note(some_camera(random, 1), time_s);
    EXPECT_EQ(recording.frames(), 31u);
    const std::vector<geom::Camera> path = geom::parse_path(recording.text(), "recording");
    ASSERT_EQ(path.size(), 31u);
    for (size_t i = 0; i < path.size(); ++i) EXPECT_EQ(path[i].time_s, double(i) / 30);
}

TEST(Recording, EndsWhereTheCameraIsToTheBit) {
    std::mt19937_64 random(2);
    view::Recording recording(0);
    recording.note(some_camera(random, 1), 0.1);
    const geom::Camera last = some_camera(random, 1);
    recording.end(last, 0.1);
    const std::vector<geom::Camera> path = geom::parse_path(recording.text(), "recording");
    EXPECT_EQ(path.back().eye, last.eye);
    EXPECT_EQ(path.back().target, last.target);
    EXPECT_EQ(path.back().up, last.up);
    const size_t count = recording.frames();
    recording.end(last, 0.1);
    EXPECT_EQ(recording.frames(), count) << "a camera that rests was added twice";
}

TEST(Recording, IsBounded) {
    view::Recording recording(0);
    recording.note({}, 1e9);
    recording.end({}, 2e9);
    EXPECT_EQ(recording.frames(), view::Recording::kMostFrames);
}

}  // namespace
