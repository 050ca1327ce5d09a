#include "view/session.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "scene/draw.h"

namespace {

const std::string kModel = std::string(QS_TEST_DATA) + "/bumpy.qs";

// Waits for what sessions tell.
class Listener {
  public:
    std::function<void()> on_news() {
        return [this] {
            const std::lock_guard lock(mutex_);
            ++count_;
            changed_.notify_all();
        };
    }
    template <class Condition>
    bool wait_until(const Condition& condition) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        for (uint64_t seen = 0; !condition();) {
            std::unique_lock lock(mutex_);
            if (!changed_.wait_until(lock, until, [&] { return count_ != seen; })) return condition();
            seen = count_;
        }
        return true;
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    uint64_t count_ = 0;
};

view::SubjectOptions small() {
    view::SubjectOptions options;
    options.backend = scene::BackendKind::cpu;
    options.width = 160, options.height = 120;
    return options;
}

view::Wish wish_of(const geom::Camera& camera) {
    view::Wish wish;
    wish.camera = camera;
    wish.width = 160, wish.height = 120;
    return wish;
}

TEST(Session, RefinesAViewAtRestToThePictureThatIsDrawnOfIt) {
    Listener listener;
    view::Session session({kModel}, small(), {}, listener.on_news());
    ASSERT_TRUE(listener.wait_until([&] { return session.opened() != nullptr; }));
    const view::Wish wish = wish_of(session.opened()->home);
    session.look(wish);
    const auto is_final = [&] { return session.picture() && session.picture()->report.is_final; };
    ASSERT_TRUE(listener.wait_until(is_final));
    const std::shared_ptr<const view::Picture> picture = session.picture();
    EXPECT_EQ(picture->report.refinement, 1);

    const splat::Model model(kModel);
    scene::ModelPainter painter(model);
    scene::DrawOptions options;
    options.cut.triangle_px = scene::kTrianglePx;
    render::Frame frame;
    painter.draw(geom::make_view(wish.camera, 160, 120), options, frame);
    EXPECT_EQ(picture->frame.rgb, frame.rgb);
    EXPECT_EQ(picture->frame.depth, frame.depth);
}

TEST(Session, DrawsTheLensAsFineAsAPictureOfThatSize) {
    Listener listener;
    view::Session session({kModel}, small(), {}, listener.on_news());
    ASSERT_TRUE(listener.wait_until([&] { return session.opened() != nullptr; }));
    view::Wish wish = wish_of(session.opened()->home);
    wish.lens = view::Lens{{80, 60}, 20, 4};
    session.look(wish);
    ASSERT_TRUE(listener.wait_until([&] { return session.picture() != nullptr; }));
    const std::shared_ptr<const view::Picture> picture = session.picture();
    ASSERT_TRUE(picture->lens.has_value());
    const splat::Model model(kModel);
    scene::ModelPainter painter(model);
    scene::DrawOptions options;
    options.cut.triangle_px = scene::kTrianglePx;
    render::Frame whole;
    painter.draw(geom::make_view(wish.camera, 640, 480), options, whole);
    const render::Frame& lens = picture->lens->frame;
    ASSERT_EQ(lens.width, 40);
    // The middle of the one is the middle of the other.
    for (int k = 0; k < 3; ++k)
        EXPECT_EQ(lens.rgb[size_t(3 * (20 * 40 + 20) + k)], whole.rgb[size_t(3 * (240 * 640 + 320) + k)]);
}

TEST(Session, HasAPictureOfEveryWishInTheEnd) {
    Listener listener;
    view::Session session({kModel}, small(), {}, listener.on_news());
    ASSERT_TRUE(listener.wait_until([&] { return session.opened() != nullptr; }));
    view::Wish wish = wish_of(session.opened()->home);
    for (int i = 0; i < 20; ++i) {
        wish.camera.eye.x += 0.01;
        wish.is_moving = i < 19;
        session.look(wish);
    }
    EXPECT_TRUE(listener.wait_until([&] {
        return session.picture() && session.picture()->report.is_final &&
               session.picture()->wish.camera.eye == wish.camera.eye;
    }));
}

TEST(Session, SaysWhyASourceCannotBeOpened) {
    Listener listener;
    view::Session session({"no-such-model.qs"}, small(), {}, listener.on_news());
    ASSERT_TRUE(listener.wait_until([&] { return session.failure() != nullptr; }));
    EXPECT_THROW(std::rethrow_exception(session.failure()), core::Error);
    EXPECT_EQ(session.opened(), nullptr);
}

TEST(Session, ThatIsClosedTellsNothingMoreAndEnds) {
    Listener listener;
    view::Session session({kModel}, small(), {}, listener.on_news());
    ASSERT_TRUE(listener.wait_until([&] { return session.opened() != nullptr; }));
    session.close();
    const std::shared_ptr<const view::Picture> last = session.picture();
    session.look(wish_of(session.opened()->home));
    while (!session.has_ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(session.picture(), last);
}

// A pipe into which nobody writes stands for a disk or a server that does not answer.
TEST(Session, OfASourceThatDoesNotAnswerIsClosedAllTheSame) {
    const std::filesystem::path pipe =
        std::filesystem::temp_directory_path() / ("qs-view-pipe-" + std::to_string(getpid()) + ".qs");
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    {
        view::Session session({pipe.string()}, small(), {}, [] {});
        session.look({});
        EXPECT_EQ(session.opened(), nullptr);
        EXPECT_EQ(session.picture(), nullptr);
        session.close();
        EXPECT_FALSE(session.has_ended());
    }
    EXPECT_TRUE(view::Session::are_some_left());
    // The thread that was left ends with what it waits for.
    const int writer = ::open(pipe.c_str(), O_WRONLY);
    ::close(writer);
    std::filesystem::remove(pipe);
}

}  // namespace
