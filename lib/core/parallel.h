// Parallel loops (oneTBB).  Work is cut by index, never by thread, so results do not depend on
// how many threads run.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <functional>

namespace core {

// Limits every later loop to `count` threads, which may be more than there are processors; 0 is
// one per processor.  Called once, by Program; tests call it between loops, never during one.
void set_thread_count(int count);
int thread_count();

// Where loops run; for algorithms of oneTBB used directly: thread_arena().execute([&] {...}).
tbb::task_arena& thread_arena();

namespace detail {
// The same loop for the thread sanitizer, which cannot see how the tasks of an uninstrumented oneTBB
// are ordered and so would report each of them.
void run_on_plain_threads(size_t count, size_t grain, const std::function<void(size_t, size_t)>& run);
}  // namespace detail

// Calls body(i) once for each i in [0, count), in any order, on any thread.  An exception thrown
// by body is thrown here.  `grain`: fewest indices given to a thread at a time.
template <class Body>
void parallel_for(size_t count, const Body& body, size_t grain = 1) {
    const auto run = [&](size_t begin, size_t end) {
        for (size_t i = begin; i != end; ++i) body(i);
    };
#ifdef __SANITIZE_THREAD__
    detail::run_on_plain_threads(count, grain, run);
#else
    using Range = tbb::blocked_range<size_t>;
    thread_arena().execute([&] {
        tbb::parallel_for(Range(0, count, grain),
                          [&](const Range& range) { run(range.begin(), range.end()); });
    });
#endif
}

// Calls body(begin, end) for pieces of [0, count) of `piece` indices (the last may be shorter).
template <class Body>
void parallel_pieces(size_t count, size_t piece, const Body& body) {
    const size_t pieces = (count + piece - 1) / piece;
    parallel_for(pieces, [&](size_t p) {
        const size_t begin = p * piece;
        body(begin, begin + piece < count ? begin + piece : count);
    });
}

}  // namespace core
