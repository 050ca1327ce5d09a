#include "core/pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

#include "core/parallel.h"

namespace core {

void take_pages(void* begin, size_t bytes) {
#ifdef MADV_POPULATE_WRITE
    constexpr size_t kPiece = size_t(4) << 20;
    const auto page = static_cast<uintptr_t>(::sysconf(_SC_PAGESIZE)),
               at = reinterpret_cast<uintptr_t>(begin);
    const uintptr_t first = (at + page - 1) / page * page, end = (at + bytes) / page * page;
    if (end < first + kPiece) return;
    parallel_pieces(end - first, kPiece, [&](size_t from, size_t to) {
        ::madvise(reinterpret_cast<void*>(first + from), to - from, MADV_POPULATE_WRITE);
    });
#else
    static_cast<void>(begin), static_cast<void>(bytes);
#endif
}

}  // namespace core
