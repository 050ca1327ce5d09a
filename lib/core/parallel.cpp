#include "core/parallel.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace core {

namespace {

// The control bounds what the library's own algorithms (sorts) take; the arena is what makes more
// threads than processors possible, which tests of "same bytes for any thread count" need.
struct Threads {
    std::optional<tbb::global_control> limit;
    std::unique_ptr<tbb::task_arena> arena = std::make_unique<tbb::task_arena>();
};

Threads& threads() {
    static Threads instance;
    return instance;
}

}  // namespace

void set_thread_count(int count) {
    Threads& current = threads();
    current.limit.reset();
    if (count > 0)
        current.limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(count));
    current.arena =
        std::make_unique<tbb::task_arena>(count > 0 ? count : static_cast<int>(tbb::task_arena::automatic));
}

int thread_count() {
    return threads().arena->max_concurrency();
}

tbb::task_arena& thread_arena() {
    return *threads().arena;
}

namespace detail {

void run_on_plain_threads(size_t count, size_t grain, const std::function<void(size_t, size_t)>& run) {
    std::atomic<size_t> next{0};
    std::exception_ptr thrown;
    std::mutex mutex;
    const auto work = [&] {
        for (size_t begin; (begin = next.fetch_add(grain)) < count;) {
            try {
                run(begin, std::min(begin + grain, count));
            } catch (...) {
                const std::lock_guard lock(mutex);
                thrown = std::current_exception();
                next = count;
            }
        }
    };
    {
        const size_t pieces = (count + grain - 1) / grain;
        std::vector<std::jthread> helpers;
        while (helpers.size() + 1 < std::min(pieces, static_cast<size_t>(thread_count())))
            helpers.emplace_back(work);
        work();
    }
    if (thrown) std::rethrow_exception(thrown);
}

}  // namespace detail

}  // namespace core
