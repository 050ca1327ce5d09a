#include "search.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <thread>

namespace {

// Which places of the code were reached, by a hash of their addresses.
constexpr size_t kPlaces = size_t(1) << 18;
std::atomic<bool> reached[kPlaces];
std::atomic<uint64_t> reached_count{0};

}  // namespace

// Called by the compiler's instrumentation wherever a piece of code without a branch begins.
extern "C" [[gnu::no_sanitize_coverage]] void __sanitizer_cov_trace_pc() {
    const auto address = reinterpret_cast<uintptr_t>(__builtin_return_address(0));
    std::atomic<bool>& place = reached[(address * 0x9e3779b97f4a7c15u) >> 46];
    if (place.load(std::memory_order_relaxed)) return;
    place.store(true, std::memory_order_relaxed);
    reached_count.fetch_add(1, std::memory_order_relaxed);
}

namespace fuzz {

void run(const Bytes& bytes) {
    const Bytes exact(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kLargest = size_t(1) << 20;
constexpr double kSlowest_s = 20;  // with sanitizers, on a busy machine

// What the searching process is at, for the one that watches it.
struct State {
    std::atomic<uint64_t> runs, kept, size;
    uint8_t input[kLargest];
};

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

// A name that the bytes alone decide: FNV-1a.
std::string name_of(const uint8_t* bytes, size_t size) {
    uint64_t hash = 0xcbf29ce484222325;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3;
    char name[17];
    std::snprintf(name, sizeof name, "%016llx", static_cast<unsigned long long>(hash));
    return name;
}

void write_file(const std::filesystem::path& path, const uint8_t* bytes, size_t size) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
}

// The searching process.
void try_inputs(const Search& s, State& state) {
    std::mt19937_64 random(s.seed);
    std::vector<Bytes> inputs = s.seeds;
    const auto attempt = [&](const Bytes& bytes) {
        std::copy(bytes.begin(), bytes.end(), state.input);
        state.size = bytes.size();
        const uint64_t before = reached_count;
        run(bytes);
        ++state.runs;
        return reached_count != before;
    };
    for (const Bytes& seed : s.seeds) attempt(seed);
    const Clock::time_point begin = Clock::now();
    while (seconds_since(begin) < s.seconds) {
        const Bytes& one = inputs[random() % inputs.size()];
        Bytes bytes = mutated_further(one, inputs[random() % inputs.size()],
                                      std::min(kLargest, 4 * one.size()), random);
        if (!attempt(bytes)) continue;
        write_file(s.kept / name_of(bytes.data(), bytes.size()), bytes.data(), bytes.size());
        ++state.kept;
        inputs.push_back(std::move(bytes));
    }
}

// Waits for the searching process; why it ended, "" if as it should.
std::string watch(pid_t process, const State& state) {
    uint64_t runs = 0;
    Clock::time_point progress = Clock::now();
    int status = 0;
    while (::waitpid(process, &status, WNOHANG) == 0) {
        if (state.runs != runs) {
            runs = state.runs;
            progress = Clock::now();
        } else if (seconds_since(progress) > kSlowest_s) {
            ::kill(process, SIGKILL);
            ::waitpid(process, &status, 0);
            return "hang";
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? "" : "crash";
}

}  // namespace

bool search(const Search& s) {
    void* const shared =
        ::mmap(nullptr, sizeof(State), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) {
        std::perror("search");
        return false;
    }
    State& state = *static_cast<State*>(shared);
    const pid_t process = ::fork();
    if (process < 0) {
        std::perror("search");
        return false;
    }
    if (process == 0) {
        try_inputs(s, state);
        std::_Exit(0);
    }
    const std::string fault = watch(process, state);
    std::printf("%llu inputs, %llu of them reached new code and were kept",
                static_cast<unsigned long long>(state.runs), static_cast<unsigned long long>(state.kept));
    if (!fault.empty()) {
        const std::string file = s.failures + fault + "-" + name_of(state.input, state.size);
        write_file(file, state.input, state.size);
        std::printf("; %s: %s", fault.c_str(), file.c_str());
    }
    std::puts("");
    return fault.empty();
}

}  // namespace fuzz
