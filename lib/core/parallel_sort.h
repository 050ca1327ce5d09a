// Sorting on all threads (oneTBB), in a header of its own since few need it.
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>

#include "core/parallel.h"

namespace core {

// As std::sort, of elements of which none are equal: the order of such would depend on the threads.  The
// thread sanitizer sees std::sort, for the reason at run_on_plain_threads().
template <class Iterator>
void parallel_sort(Iterator first, Iterator last) {
#ifdef __SANITIZE_THREAD__
    std::sort(first, last);
#else
    thread_arena().execute([&] { tbb::parallel_sort(first, last); });
#endif
}

}  // namespace core
