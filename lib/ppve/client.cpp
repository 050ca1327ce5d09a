#include "ppve/client.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "core/stopwatch.h"
#include "net/frame_stream.h"
#include "ppve/client/eye_track.h"
#include "ppve/client/point_cache.h"

namespace ppve {

using core::text;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double kPoll = 0.05;  // seconds after which a thread that waits for messages looks up
constexpr double kFirstPause = 0.25, kLongestPause = 4;  // before connecting again
// In a row, where somebody waits; of a server that has never welcomed us the first one is final.
constexpr int kMostFailures = 3;

bool is_same(const geom::Camera& a, const geom::Camera& b) {
    return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fovy_deg == b.fovy_deg;
}

// What is to be asked for next.
struct Wish {
    Frustum frustum;
    bool is_at_rest = false;
    uint64_t rest = 0;  // of which rest it is, and of which eye; beyond the last: what surrounds the picture
    size_t eye = 0;
};

}  // namespace

struct Client::State {
    State(OpenLink open_link, const ClientOptions& wanted)
        : open(std::move(open_link)), options(wanted), thread([this] { run(); }) {}
    ~State() {
        {
            const std::lock_guard lock(mutex);
            is_stopping = true;
        }
        woken.notify_all();
        thread.join();
    }

    // Of the thread that draws.
    void look(const Gaze& gaze);
    bool is_hopeless_locked() const {
        return failures_in_a_row >= (counts.connections == 0 ? 1 : kMostFailures);
    }
    bool is_settled_locked() const {
        return settled_eyes >= gaze.eyes.size() && settled_rest == rest && has_gaze;
    }

    // Of the network's thread.
    void run();
    void serve(Link& link);
    Welcome welcome_from(Link& link);
    std::optional<Wish> wait_for_wish(const Link& link, uint64_t most_pixels);
    std::optional<Wish> next_wish_locked(uint64_t most_pixels);
    Request request_of(const Wish& wish, uint64_t id);
    std::optional<Message> wait_for_answer(Link& link);
    void take_in(const Answer& answer, const Wish& wish, double latency_s);
    void pause(double seconds);
    bool stops() {
        const std::lock_guard lock(mutex);
        return is_stopping;
    }

    const OpenLink open;
    const ClientOptions options;

    // The lock order is this one alone; it is never held while anything else is waited for.
    mutable std::mutex mutex;
    std::condition_variable woken, changed;
    bool is_stopping = false, has_gaze = false, is_over = false;
    Gaze gaze;
    EyeTrack track;
    uint64_t gaze_number = 0, asked_gaze = 0;  // of the newest look, of that which was last asked for
    uint64_t rest = 0;                         // counts places where the eye has been
    uint64_t settled_rest = 0;
    size_t settled_eyes = 0;  // of the rest, that are done
    std::shared_ptr<const PointModel> model = std::make_shared<PointModel>();
    // Drawn models that the other thread has not been told of; those before are as good as forgotten.
    std::shared_ptr<const PointModel> drawn_model;
    std::vector<uint8_t> drawn_seen;
    ClientCounts counts;
    std::optional<Box> bounds;
    int failures_in_a_row = 0;
    std::string refusal;

    // The network thread's own.
    std::unique_ptr<PointCache> cache;
    Latency latency;
    uint64_t last_id = 0;

    std::jthread thread;  // last: runs while all else is there
};

void Client::State::look(const Gaze& seen) {
    {
        const std::lock_guard lock(mutex);
        if (!has_gaze || !is_same(seen.camera, gaze.camera)) {
            ++rest;
            refusal.clear();
        }
        gaze = seen;
        has_gaze = true;
        ++gaze_number;
        track.add(seen.time_s, seen.camera);
    }
    woken.notify_all();
}

// Moving: ahead of the eye, each look once.  At rest: each eye's own picture, once, and what surrounds it.
std::optional<Wish> Client::State::next_wish_locked(uint64_t most_pixels) {
    if (!has_gaze || !refusal.empty()) return std::nullopt;
    const bool is_at_rest = gaze.is_still || track.still_s() >= options.rest_s;
    if (is_at_rest) {
        const size_t eye = settled_rest == rest ? settled_eyes : 0;
        if (eye == gaze.eyes.size() && !gaze.is_still && options.predicts)
            return Wish{frustum_for(gaze.camera, field_of(gaze.camera, gaze.eyes), options.width,
                                    options.height, kSurroundings, most_pixels),
                        true, rest, eye};
        if (eye >= gaze.eyes.size()) return std::nullopt;
        Frustum frustum{gaze.eyes[eye], Projection::perspective};
        frustum.view.near.reset(), frustum.view.far.reset();
        if (uint64_t(frustum.view.width) * uint64_t(frustum.view.height) > most_pixels)
            frustum = frustum_for(gaze.camera, field_of(gaze.camera, gaze.eyes), frustum.view.width,
                                  frustum.view.height, 0, most_pixels);
        return Wish{frustum, true, rest, eye};
    }
    if (asked_gaze == gaze_number) return std::nullopt;
    asked_gaze = gaze_number;
    geom::Camera camera = gaze.camera;
    double margin_rad = 0;
    if (options.predicts) {
        // The answer is there after one period and is drawn during another: its middle.
        camera = track.at(gaze.time_s + 1.5 * latency.seconds());
        margin_rad = 0.5 * track.turning_rad_per_s() * latency.seconds();
    }
    const FieldOfView field = field_of(gaze.camera, gaze.eyes);
    return Wish{frustum_for(camera, field, options.width, options.height, margin_rad, most_pixels), false,
                rest, 0};
}

std::optional<Wish> Client::State::wait_for_wish(const Link& link, uint64_t most_pixels) {
    std::unique_lock lock(mutex);
    if (link.is_over()) {
        is_over = true;
        changed.notify_all();
        woken.wait(lock, [&] { return is_stopping; });
    }
    while (!is_stopping) {
        if (auto wish = next_wish_locked(most_pixels)) return wish;
        // An eye comes to rest by doing nothing; and a server may have gone, which receiving finds out.
        woken.wait_for(lock, std::chrono::duration<double>(kPoll));
    }
    return std::nullopt;
}

// Empty where none comes soon.
std::optional<Message> first_message_of(Link& link) {
    try {
        const std::vector<std::byte> bytes = link.receive(kPoll);
        if (bytes.empty()) return std::nullopt;
        return parse(bytes, "server");
    } catch (const net::ConnectionLost&) {
        throw;
    } catch (const core::Error& error) {
        throw core::Error(std::string("server: does not speak as ppve-sample does: ") + error.what());
    }
}

Welcome Client::State::welcome_from(Link& link) {
    const auto start = Clock::now();
    while (seconds_since(start) < options.answer_timeout_s && !stops()) {
        std::optional<Message> first = first_message_of(link);
        if (!first) continue;
        Message& message = *first;
        if (const auto* refusal_sent = std::get_if<Refusal>(&message))
            throw core::Error(refusal_sent->reason);
        if (auto* welcome = std::get_if<Welcome>(&message)) {
            if (welcome->version != kProtocolVersion)
                throw core::Error(
                    text("server: speaks version %u, this client %u", welcome->version, kProtocolVersion));
            return std::move(*welcome);
        }
        throw core::Error("server: its first message is no welcome");
    }
    throw core::Error(text("server: has not said anything for %g s", options.answer_timeout_s));
}

Request Client::State::request_of(const Wish& wish, uint64_t id) {
    std::shared_ptr<const PointModel> drawn;
    std::vector<uint8_t> seen;
    Request request;
    double now_s = 0;
    {
        const std::lock_guard lock(mutex);
        drawn = std::move(drawn_model);
        seen = std::move(drawn_seen);
        drawn_model = nullptr;
        now_s = gaze.time_s;
    }
    if (drawn) cache->note_drawn(*drawn, seen, now_s);
    request.id = id;
    request.frustum = wish.frustum;
    request.bound_px = options.bound_px;
    request.codec = options.codec;
    request.elimination = options.elimination;
    request.epsilon = options.epsilon;
    request.wants_normals = options.wants_normals;
    request.last_answer = cache->last_answer();
    request.octree_checksum = cache->tree().checksum();
    request.deletions = cache->obsolete(now_s, options.keep_s, options.most_bytes);
    return request;
}

std::optional<Message> Client::State::wait_for_answer(Link& link) {
    const auto start = Clock::now();
    while (!stops()) {
        const std::vector<std::byte> bytes = link.receive(kPoll);
        if (!bytes.empty()) {
            const std::lock_guard lock(mutex);
            counts.bytes_received += bytes.size();
            return parse(bytes, "server");
        }
        if (link.is_over()) return std::nullopt;
        if (seconds_since(start) > options.answer_timeout_s)
            throw core::Error(text("server: has not answered for %g s", options.answer_timeout_s));
    }
    return std::nullopt;
}

void Client::State::take_in(const Answer& answer, const Wish& wish, double latency_s) {
    core::Stopwatch watch;
    double now_s = 0;
    {
        const std::lock_guard lock(mutex);
        now_s = gaze.time_s;
    }
    const PointCache::Taken taken = cache->take_in(answer, now_s);
    const double take_in_ms = watch.lap_ms();
    latency.add(latency_s + take_in_ms / 1000);
    const std::lock_guard lock(mutex);
    model = cache->model();
    ++counts.updates;
    counts.updates_at_rest += wish.is_at_rest;
    counts.samples += answer.samples;
    counts.samples_kept += taken.samples_kept;
    counts.points_removed += taken.points_removed;
    counts.clusters_deleted += answer.deleted.size();
    counts.out_of_step += !taken.is_in_step;
    counts.points = cache->tree().points();
    counts.clusters = cache->tree().clusters();
    counts.bytes = cache->bytes();
    counts.most_bytes = std::max(counts.most_bytes, counts.bytes);
    counts.latency_s = latency.seconds();
    counts.server_ms = double(answer.sample_ms) + double(answer.eliminate_ms) + double(answer.encode_ms);
    counts.take_in_ms = take_in_ms;
    failures_in_a_row = 0;
    // Out of step, the model may lack what the server takes for known: asked for again, it begins anew.
    if (wish.is_at_rest && taken.is_in_step && wish.rest == rest) {
        settled_rest = rest;
        settled_eyes = wish.eye + 1;
    }
    changed.notify_all();
}

void Client::State::serve(Link& link) {
    const Welcome welcome = welcome_from(link);
    const TreeShape shape = shape_around(welcome.bounds);
    cache = std::make_unique<PointCache>(shape);
    {
        const std::lock_guard lock(mutex);
        ++counts.connections;
        settled_eyes = 0;
        bounds = welcome.bounds;
        changed.notify_all();
    }
    while (!stops()) {
        const std::optional<Wish> wish = wait_for_wish(link, welcome.most_pixels);
        if (!wish) return;
        const uint64_t id = ++last_id;
        const auto start = Clock::now();
        link.send(format(request_of(*wish, id)), options.answer_timeout_s);
        const std::optional<Message> message = wait_for_answer(link);
        if (!message) continue;
        if (const auto* answer = std::get_if<Answer>(&*message)) {
            take_in(*answer, *wish, seconds_since(start));
        } else if (const auto* refused = std::get_if<Refusal>(&*message)) {
            const std::lock_guard lock(mutex);
            ++counts.refusals;
            refusal = refused->reason;
            changed.notify_all();
        } else {
            throw core::Error("server: answers a request by a message that is no answer");
        }
    }
}

void Client::State::run() {
    double pause_s = kFirstPause;
    while (!stops()) {
        try {
            const std::unique_ptr<Link> link = open();
            serve(*link);
        } catch (const std::exception& error) {
            const std::lock_guard lock(mutex);
            if (failures_in_a_row == 0) pause_s = kFirstPause;
            ++counts.failures;
            ++failures_in_a_row;
            counts.failure = error.what();
            changed.notify_all();
        }
        pause(pause_s);
        pause_s = std::min(2 * pause_s, kLongestPause);
    }
}

void Client::State::pause(double seconds) {
    std::unique_lock lock(mutex);
    woken.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return is_stopping; });
}

Client::Client(OpenLink open, const ClientOptions& options)
    : state_(std::make_unique<State>(std::move(open), options)) {}
Client::~Client() = default;

void Client::look(const Gaze& gaze) {
    state_->look(gaze);
}

std::shared_ptr<const PointModel> Client::model() const {
    const std::lock_guard lock(state_->mutex);
    return state_->model;
}

void Client::note_drawn(const PointModel& model, const std::vector<uint8_t>& seen) {
    const std::lock_guard lock(state_->mutex);
    // Of the same model, what any picture since has shown.
    if (state_->drawn_model.get() == &model && state_->drawn_seen.size() == seen.size()) {
        for (size_t k = 0; k < seen.size(); ++k) state_->drawn_seen[k] |= seen[k];
        return;
    }
    if (state_->model.get() != &model) return;
    state_->drawn_model = state_->model;
    state_->drawn_seen = seen;
}

bool Client::is_settled() const {
    const std::lock_guard lock(state_->mutex);
    return state_->is_settled_locked();
}

ClientCounts Client::counts() const {
    const std::lock_guard lock(state_->mutex);
    return state_->counts;
}

void Client::wait_until_settled() {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] {
        return state_->is_settled_locked() || state_->is_over || !state_->refusal.empty() ||
               state_->is_hopeless_locked();
    });
    if (!state_->refusal.empty()) throw core::Error("server: " + state_->refusal);
    if (state_->is_hopeless_locked()) throw core::Error(state_->counts.failure);
}

Box Client::wait_for_bounds() {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return state_->bounds || state_->is_hopeless_locked(); });
    if (!state_->bounds) throw core::Error(state_->counts.failure);
    return *state_->bounds;
}

}  // namespace ppve
