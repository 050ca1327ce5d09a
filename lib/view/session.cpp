#include "view/session.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>

#include "core/error.h"

namespace view {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

// Between two looks whether something has arrived.
constexpr Seconds kLook{0.01};
// That a session is waited for when it is closed: longer than any frame should take.
constexpr Seconds kPatience{0.5};

std::atomic<int> left_count = 0;

// What was saved is no reason not to open what it was saved of.
void find_views(const std::vector<std::string>& sources, Opened& opened) {
    const auto tried = [&](const auto& attempt) {
        try {
            attempt();
        } catch (const core::Error& error) {
            opened.views_trouble = error.what();
        }
    };
    tried([&] { opened.views_folder = views_folder(sources); });
    if (opened.views_folder.empty()) return;
    for (size_t number = 0; number < opened.views.size(); ++number)
        tried([&] { opened.views[number] = read_view(opened.views_folder, number); });
}

std::string name_of(const std::vector<std::string>& sources) {
    std::string name;
    for (const std::string& source : sources) name += (name.empty() ? "" : " ") + source;
    return name;
}

}  // namespace

struct Session::State {
    std::vector<std::string> sources;
    SubjectOptions options;
    scene::CameraOptions camera;

    std::mutex mutex;
    std::condition_variable changed;
    std::function<void()> on_news;  // null once nobody wants to hear of it
    bool is_closed = false, has_ended = false;
    std::optional<Wish> wish;
    uint64_t wish_number = 0;
    std::shared_ptr<const Opened> opened;
    std::shared_ptr<const Picture> picture;
    std::exception_ptr failure;

    // Of the session's thread.
    std::unique_ptr<Subject> subject;
    std::shared_ptr<Picture> spare;
    uint64_t picture_number = 0;

    void run();
    void open();
    void draw_until_closed();
    bool waits_for_work(Wish& wish, uint64_t& seen);
    bool is_drawn(const Wish& wish);
    void draw(const Wish& wish);
    std::shared_ptr<Picture> blank_picture();
    void publish(std::shared_ptr<Picture> made);
    template <class Change>
    void tell(const Change& change);
};

template <class Change>
void Session::State::tell(const Change& change) {
    const std::lock_guard lock(mutex);
    change();
    if (on_news) on_news();
}

void Session::State::run() {
    try {
        open();
        draw_until_closed();
    } catch (...) {
        tell([&] { failure = std::current_exception(); });
    }
    subject.reset();
    const std::lock_guard lock(mutex);
    has_ended = true;
    changed.notify_all();
}

void Session::State::open() {
    const auto begin = Clock::now();
    subject = open_subject(sources, options);
    const std::vector<geom::Sphere> outline = subject->outline();
    auto made = std::make_shared<Opened>();
    made->bounds = subject->bounds();
    made->home = camera.camera(made->bounds, outline, double(options.width) / options.height);
    made->description = subject->describe();
    find_views(sources, *made);
    made->opening_s = Seconds(Clock::now() - begin).count();
    tell([&] { opened = std::move(made); });
}

// Until there is something to draw; false where the session is closed.
bool Session::State::waits_for_work(Wish& current, uint64_t& seen) {
    std::unique_lock lock(mutex);
    for (;;) {
        if (is_closed) return false;
        if (wish_number != seen) {
            seen = wish_number, current = *wish;
            return true;
        }
        if (seen > 0) {
            lock.unlock();
            const bool has_more = subject->has_more(current);
            lock.lock();
            if (has_more) return !is_closed;
        }
        const auto is_news = [&] { return is_closed || wish_number != seen; };
        if (seen > 0 && subject->is_arriving())
            changed.wait_for(lock, kLook, is_news);
        else
            changed.wait(lock, is_news);
    }
}

void Session::State::draw_until_closed() {
    Wish current;
    uint64_t seen = 0;
    while (waits_for_work(current, seen)) draw(current);
}

// The one that was shown before the last, where nobody looks at it any more.
std::shared_ptr<Picture> Session::State::blank_picture() {
    std::shared_ptr<Picture> blank = std::move(spare);
    if (!blank || blank.use_count() != 1) return std::make_shared<Picture>();
    // The count is read without order: what whoever had it last has read of it, it has read before this.
    std::atomic_thread_fence(std::memory_order_acquire);
    return blank;
}

// What is drawn as well as it can be is not drawn again for a lens that moves over it.
bool Session::State::is_drawn(const Wish& current) {
    return picture && show_the_same(picture->wish, current) && !subject->is_arriving() &&
           !subject->has_more(current);
}

void Session::State::draw(const Wish& current) {
    std::shared_ptr<Picture> made = blank_picture();
    made->number = ++picture_number;
    made->wish = current;
    made->view = geom::make_view(current.camera, current.width, current.height);
    if (is_drawn(current))
        made->frame = picture->frame, made->report = picture->report;
    else
        made->report = subject->draw(current, made->frame);
    made->lens.reset();
    if (current.lens) {
        made->lens.emplace();
        made->lens->lens = *current.lens;
        subject->draw_part(view_of(*current.lens, made->view), current, made->lens->frame);
    }
    publish(std::move(made));
}

void Session::State::publish(std::shared_ptr<Picture> made) {
    tell([&] {
        spare = std::const_pointer_cast<Picture>(picture);
        picture = std::move(made);
    });
}

Session::Session(std::vector<std::string> sources, const SubjectOptions& options,
                 const scene::CameraOptions& camera, std::function<void()> on_news)
    : name_(name_of(sources)), state_(std::make_shared<State>()) {
    state_->sources = std::move(sources);
    state_->options = options;
    state_->camera = camera;
    state_->on_news = std::move(on_news);
    thread_ = std::thread([state = state_] { state->run(); });
}

Session::~Session() {
    close();
    std::unique_lock lock(state_->mutex);
    const bool has_ended = state_->changed.wait_for(lock, kPatience, [&] { return state_->has_ended; });
    lock.unlock();
    if (has_ended) {
        thread_.join();
    } else {
        thread_.detach();
        ++left_count;
    }
}

void Session::close() {
    const std::lock_guard lock(state_->mutex);
    state_->is_closed = true;
    state_->on_news = nullptr;
    state_->changed.notify_all();
}

bool Session::has_ended() const {
    const std::lock_guard lock(state_->mutex);
    return state_->has_ended;
}

bool Session::are_some_left() {
    return left_count > 0;
}

void Session::look(const Wish& wish) {
    const std::lock_guard lock(state_->mutex);
    const std::optional<Wish>& before = state_->wish;
    if (before && show_the_same(*before, wish) && before->is_moving == wish.is_moving &&
        before->budget_ms == wish.budget_ms && are_same(before->lens, wish.lens))
        return;
    state_->wish = wish;
    ++state_->wish_number;
    state_->changed.notify_all();
}

std::shared_ptr<const Opened> Session::opened() const {
    const std::lock_guard lock(state_->mutex);
    return state_->opened;
}

std::shared_ptr<const Picture> Session::picture() const {
    const std::lock_guard lock(state_->mutex);
    return state_->picture;
}

std::exception_ptr Session::failure() const {
    const std::lock_guard lock(state_->mutex);
    return state_->failure;
}

}  // namespace view
