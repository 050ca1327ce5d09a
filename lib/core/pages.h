// Memory taken from the system by all threads at once.  What one thread writes first, it takes page by page,
// while the others wait: for large arrays that costs more than filling them.
#pragma once

#include <cstddef>
#include <vector>

namespace core {

// Takes the pages of `bytes` of memory that is about to be written.  A hint: what the system does not give
// now, it gives when it is written.
void take_pages(void* begin, size_t bytes);

// The vectors' functions of these names, with their memory taken by all threads.
template <class T>
void reserve(std::vector<T>& v, size_t count) {
    v.reserve(count);
    take_pages(v.data(), count * sizeof(T));
}
template <class T>
void resize(std::vector<T>& v, size_t count) {
    reserve(v, count);
    v.resize(count);
}

}  // namespace core
