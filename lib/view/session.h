// A source that is looked at: opened and drawn by a thread of its own, so that whoever has the window never
// waits.
//
// It waits for disks and networks as long as these take.  One that is closed while it waits is left to
// itself: it touches nothing but its own, and ends when what it waits for does.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "scene/camera_options.h"
#include "view/picture.h"
#include "view/saved_views.h"
#include "view/subject.h"

namespace view {

// What the window is told.
struct Opened {
    geom::Camera home;
    geom::Sphere bounds;
    std::string description;
    // Those saved of it before, and where more are kept; empty where they are not.
    SavedViews views{};
    std::string views_folder{};
    std::string views_trouble{};  // why they are not kept, or one could not be read
    double opening_s = 0;
};

class Session {
  public:
    // `on_news`: called from the session's thread whenever there is something new to ask for here; must not
    // wait.
    Session(std::vector<std::string> sources, const SubjectOptions& options,
            const scene::CameraOptions& camera, std::function<void()> on_news);
    ~Session();  // waits, but not longer than a frame should take
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    const std::string& name() const { return name_; }  // of the sources, for people

    // None of these waits.  What is wished for takes the place of the wish before.
    void look(const Wish& wish);
    // null while it is being opened.
    std::shared_ptr<const Opened> opened() const;
    // The newest; null before the first.
    std::shared_ptr<const Picture> picture() const;
    // Draws no more, and ends when it can: from then on nothing is told, and whoever must not wait for the
    // destructor asks has_ended() before.
    void close();
    bool has_ended() const;
    // Why it could not be opened, or not be drawn any more; null while nothing is wrong.
    std::exception_ptr failure() const;

    // Whether there are sessions that were closed while they waited, and wait still: then the process is to
    // end without the destructors of what is shared.
    static bool are_some_left();

  private:
    struct State;
    std::string name_;
    std::shared_ptr<State> state_;
    std::thread thread_;
};

}  // namespace view
