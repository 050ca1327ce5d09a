#include "core/messages.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>

#include "core/error.h"
#include "core/file.h"
#include "core/settings.h"

namespace core {

Settings settings;
std::atomic<bool> has_failed{false};

namespace {

// Standard error holds whole lines and at most one progress line, which is erased before others.
std::mutex talk_mutex;
bool progress_is_drawn = false;

void erase_progress() {
    if (progress_is_drawn) std::fputs("\r\033[K", stderr);
    progress_is_drawn = false;
}

}  // namespace

void say(const std::string& line) {
    const std::lock_guard lock(talk_mutex);
    erase_progress();
    std::fputs((settings.program + ": " + line + "\n").c_str(), stderr);
}

void warn(const std::string& sentence) {
    if (!settings.quiet) say("warning: " + sentence);
}

void notice(const std::string& sentence) {
    if (settings.verbose) say(sentence);
}

bool is_quiet() {
    return settings.quiet;
}

void fail(const std::string& sentence) {
    has_failed = true;
    say(sentence);
}

void print(std::string_view text) {
    {
        const std::lock_guard lock(talk_mutex);
        erase_progress();
    }
    write_standard_output(text, false);
}

struct Progress::State {
    using Clock = std::chrono::steady_clock;

    std::string what;
    uint64_t total;
    bool drawn;
    std::mutex mutex;
    Clock::time_point next;

    void draw(uint64_t done) {
        std::string line = "\r" + settings.program + ": " + what + " ";
        if (total > 0) {
            line += text("%.0f%%",
                         100.0 * static_cast<double>(std::min(done, total)) / static_cast<double>(total));
        } else {
            line += std::to_string(done);
        }
        const std::lock_guard lock(talk_mutex);
        std::fputs((line + "\033[K").c_str(), stderr);
        progress_is_drawn = true;
        next = Clock::now() + std::chrono::milliseconds(100);
    }
};

Progress::Progress(std::string what, uint64_t total) : state_(std::make_unique<State>()) {
    state_->what = std::move(what);
    state_->total = total;
    const bool wanted =
        settings.progress == "always" || (settings.progress == "auto" && ::isatty(STDERR_FILENO));
    state_->drawn = wanted && !settings.quiet;
    if (state_->drawn) state_->draw(0);
}

Progress::~Progress() {
    if (!state_->drawn) return;
    const std::lock_guard lock(talk_mutex);
    erase_progress();
}

void Progress::update(uint64_t done) {
    if (!state_->drawn) return;
    // A thread that finds another one drawing goes on with its work.
    const std::unique_lock lock(state_->mutex, std::try_to_lock);
    if (lock && State::Clock::now() >= state_->next) state_->draw(done);
}

}  // namespace core
