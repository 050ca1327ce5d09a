// Parallel loops (oneTBB).  Work is cut by index, never by thread, so results do not depend on
// how many threads run.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace core {

// Limits every later loop to `count` threads, which may be more than there are processors; 0 is
// one per processor.  Called once, by Program; tests call it between loops, never during one.
void set_thread_count(int count);
int thread_count();

// Where loops run; for algorithms of oneTBB used directly: thread_arena().execute([&] {...}).
tbb::task_arena& thread_arena();

// Calls body(i) once for each i in [0, count), in any order, on any thread.  An exception thrown
// by body is thrown here.  `grain`: fewest indices given to a thread at a time.
template <class Body>
void parallel_for(size_t count, const Body& body, size_t grain = 1) {
    thread_arena().execute([&] {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                          [&](const tbb::blocked_range<size_t>& range) {
                              for (size_t i = range.begin(); i != range.end(); ++i) body(i);
                          });
    });
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
