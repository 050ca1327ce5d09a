#include "core/parallel.h"

#include <tbb/global_control.h>

#include <memory>
#include <optional>

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

}  // namespace core
