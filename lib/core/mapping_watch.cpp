#include "core/mapping_watch.h"

#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "core/settings.h"

namespace core {

namespace {

// One that is not among these is not told of: the signal ends the program.
struct Mapping {
    std::atomic<uintptr_t> begin{0}, end{0};  // 0, 0: free
    char name[PATH_MAX];
};
std::array<Mapping, 64> mappings;
std::mutex mappings_mutex;
std::atomic<void (*)()> tidy_up{nullptr};
static_assert(std::atomic<uintptr_t>::is_always_lock_free && decltype(tidy_up)::is_always_lock_free);

struct sigaction before;  // what the signal did

extern "C" void say_file_was_cut_and_end(int signal, siginfo_t* info, void*) {
    const auto at = reinterpret_cast<uintptr_t>(info->si_addr);
    for (const Mapping& mapping : mappings) {
        if (at < mapping.begin || at >= mapping.end) continue;
        // Of several threads that find it at once the first one tells.
        static std::atomic<bool> is_told{false};
        while (is_told.exchange(true)) ::pause();
        tidy_up.load()();
        const char* const parts[] = {settings.program.c_str(), ": ", mapping.name,
                                     ": was made shorter while it was read; replace files by renaming\n"};
        iovec line[4];
        for (int k = 0; k < 4; ++k) line[k] = {const_cast<char*>(parts[k]), std::strlen(parts[k])};
        if (::writev(STDERR_FILENO, line, 4) < 0) {
            // There is nobody left to tell.
        }
        ::_exit(1);
    }
    sigaction(signal, &before, nullptr);  // the access is made again, and is not ours
}

void install_handler() {
    struct sigaction action = {};
    action.sa_sigaction = say_file_was_cut_and_end;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGBUS, &action, &before);
}

}  // namespace

void watch_mapping(const std::byte* data, size_t size, const std::string& name, void (*tidy)()) {
    const std::scoped_lock lock(mappings_mutex);
    tidy_up = tidy;
    static std::once_flag once;
    std::call_once(once, install_handler);
    for (Mapping& mapping : mappings) {
        if (mapping.end != 0) continue;
        std::snprintf(mapping.name, sizeof(mapping.name), "%s", name.c_str());
        mapping.begin = reinterpret_cast<uintptr_t>(data);
        mapping.end = mapping.begin + size;
        return;
    }
}

void forget_mapping(const std::byte* data) {
    const std::scoped_lock lock(mappings_mutex);
    for (Mapping& mapping : mappings)
        if (mapping.begin == reinterpret_cast<uintptr_t>(data)) mapping.end = 0, mapping.begin = 0;
}

}  // namespace core
