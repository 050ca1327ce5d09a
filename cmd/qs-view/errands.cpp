#include "qs-view/errands.h"

#include <filesystem>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"

namespace qs_view {

namespace {

std::string free_name(const std::string& ending) {
    constexpr int kMost = 9999;
    for (int number = 1; number <= kMost; ++number) {
        const std::string name = core::text("qs-view-%04d.", number) + ending;
        std::error_code unknown;
        if (!std::filesystem::exists(name, unknown)) return name;
    }
    throw core::Error("qs-view-0001." + ending + " to qs-view-9999." + ending + " are all taken");
}

}  // namespace

Errands::Errands(std::function<void()> on_done) : on_done_(std::move(on_done)), thread_([this] { run(); }) {}

Errands::~Errands() {
    {
        const std::lock_guard lock(mutex_);
        is_ending_ = true;
        changed_.notify_all();
    }
    thread_.join();
}

void Errands::write(const std::string& name, const std::string& ending, std::function<std::string()> make) {
    add([name, ending, make = std::move(make)] {
        const std::string bytes = make();
        core::OutputFile file(name.empty() ? free_name(ending) : name);
        file.write(bytes);
        file.commit();
        return file.name();
    });
}

void Errands::add(Errand errand) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(errand));
    changed_.notify_all();
}

std::vector<std::string> Errands::news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(news_, {});
}

bool Errands::are_done() {
    const std::lock_guard lock(mutex_);
    return waiting_.empty() && !is_busy_;
}

void Errands::finish() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_.empty() && !is_busy_; });
}

std::string Errands::do_it(const Errand& errand) {
    try {
        const std::string name = errand();
        core::notice("wrote " + name);
        return "wrote " + name;
    } catch (const core::Error& error) {
        core::fail(error.what());
        return error.what();
    }
}

void Errands::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return is_ending_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const Errand errand = std::move(waiting_.front());
        waiting_.pop_front();
        is_busy_ = true;
        lock.unlock();
        std::string said = do_it(errand);
        lock.lock();
        is_busy_ = false;
        news_.push_back(std::move(said));
        changed_.notify_all();
        on_done_();
    }
}

}  // namespace qs_view
