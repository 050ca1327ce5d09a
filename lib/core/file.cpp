#include "core/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

#include "core/descriptor.h"
#include "core/mapping_watch.h"

namespace core {

namespace {

constexpr const char* kStandardOutput = "standard output";

// The temporary names that a signal must remove.  The handler may run on any thread at any moment,
// so the table is fixed, and a slot says how far its owner has come:
//   kOpening  the file may come into being now; the owner has signals blocked, so a handler on
//             another thread waits for it;
//   kArmed    `path` is complete and is to be removed.
struct Slot {
    enum State : int { kFree, kOpening, kArmed };
    std::atomic<int> state{kFree};
    char path[PATH_MAX];
};
std::array<Slot, 64> slots;
std::atomic<bool> dying{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

// For threads that notice that another one's handler is about to end the program: what they would
// find now, such as a missing temporary file, is not to be reported.
[[noreturn]] void wait_for_death() {
    for (;;) ::pause();
}

constexpr std::array kFatalSignals{SIGINT, SIGTERM, SIGHUP};

void remove_temporaries() {
    dying = true;
    for (Slot& slot : slots) {
        while (slot.state == Slot::kOpening) {
        }
        if (slot.state == Slot::kArmed) ::unlink(slot.path);
    }
}

extern "C" void remove_temporaries_and_die(int signal) {
    remove_temporaries();
    // The signal is blocked until this handler returns; then it kills, as the parent expects.
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

void install_signal_handlers() {
    static const bool once = [] {
        struct sigaction action = {};
        action.sa_handler = remove_temporaries_and_die;
        for (int signal : kFatalSignals) sigaddset(&action.sa_mask, signal);
        for (int signal : kFatalSignals) {
            struct sigaction before = {};
            sigaction(signal, nullptr, &before);
            // nohup's choice is kept, and that of a server, which ends by itself and tidies up.
            if (before.sa_handler == SIG_DFL) sigaction(signal, &action, nullptr);
        }
        return true;
    }();
    static_cast<void>(once);
}

// Outputs that somebody waits for: one is counted from its making until its reader has gone.
std::atomic<int> wanted_outputs{0};

class Wanted {
  public:
    Wanted() { ++wanted_outputs; }
    ~Wanted() { drop(); }
    Wanted(const Wanted&) = delete;
    Wanted& operator=(const Wanted&) = delete;
    explicit operator bool() const { return is_counted_; }
    void drop() { wanted_outputs -= std::exchange(is_counted_, false); }

  private:
    bool is_counted_ = true;
};

class SignalsBlocked {
  public:
    SignalsBlocked() {
        sigset_t fatal;
        sigemptyset(&fatal);
        for (int signal : kFatalSignals) sigaddset(&fatal, signal);
        pthread_sigmask(SIG_BLOCK, &fatal, &before_);
    }
    ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

  private:
    sigset_t before_;
};

// A temporary file that is removed by release() or a signal.
class Temporary {
  public:
    // Opens a new file for writing in `folder` (with its final slash; empty: the working folder).
    // -1 with errno set where the system refuses.
    int open(const std::string& folder);
    const char* path() const { return slot_->path; }
    void remove() {
        if (slot_ && slot_->state == Slot::kArmed) ::unlink(slot_->path);
    }
    ~Temporary() {
        if (slot_) slot_->state = Slot::kFree;
    }

  private:
    void take_slot();
    Slot* slot_ = nullptr;
};

void Temporary::take_slot() {
    for (Slot& slot : slots) {
        int expected = Slot::kFree;
        if (slot.state.compare_exchange_strong(expected, Slot::kOpening)) {
            slot_ = &slot;
            break;
        }
    }
    if (!slot_) throw Error(text("more than %zu outputs are open at once", slots.size()));
    if (!dying) return;
    slot_->state = Slot::kFree;
    wait_for_death();
}

int Temporary::open(const std::string& folder) {
    install_signal_handlers();
    static std::atomic<unsigned> next{0};
    // The name does not contain the target's, which may already be as long as a name can be.
    timespec now = {};
    clock_gettime(CLOCK_REALTIME, &now);
    const SignalsBlocked blocked;
    take_slot();
    int fd = -1;
    for (int attempt = 0; attempt < 100 && fd < 0; ++attempt) {
        const int length =
            std::snprintf(slot_->path, sizeof slot_->path, "%s.qs-%d-%lx-%u.tmp", folder.c_str(),
                          static_cast<int>(::getpid()), static_cast<unsigned long>(now.tv_nsec), next++);
        if (length >= static_cast<int>(sizeof slot_->path)) {
            errno = ENAMETOOLONG;
            break;
        }
        fd = ::open(slot_->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0 && errno != EEXIST) break;
    }
    if (fd >= 0) {
        slot_->state = Slot::kArmed;
    } else {
        slot_->state = Slot::kFree;
        slot_ = nullptr;
    }
    return fd;
}

std::string folder_of(const std::string& path) {
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

void write_all(int fd, std::span<const std::byte> data, const std::string& name) {
    while (!data.empty()) {
        const ssize_t written = ::write(fd, data.data(), data.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            if (errno == EPIPE) throw ClosedPipe{};
            fail_with_errno(name, "cannot write");
        }
        data = data.subspan(static_cast<size_t>(written));
    }
}

// Calls `write`; where a reader has gone, that is no reason to stop as long as others wait.
template <class Write>
void while_others_wait(const Write& write) {
    try {
        write();
    } catch (const ClosedPipe&) {
        if (wanted_outputs == 0) throw;
    }
}

void put_to_standard_output(std::string_view data, bool flush) {
    static std::atomic<bool> is_closed{false};
    if (is_closed) throw ClosedPipe{};
    const bool written = data.empty() || std::fwrite(data.data(), 1, data.size(), stdout) == data.size();
    if (written && (!flush || std::fflush(stdout) == 0) && !std::ferror(stdout)) return;
    if (errno != EPIPE) fail_with_errno(kStandardOutput, "cannot write");
    is_closed = true;
    throw ClosedPipe{};
}

// Bytes of unknown number.  Doubling keeps the copying linear; nothing is believed about the size.
struct Contents {
    std::byte* data = nullptr;
    size_t size = 0;
};

Contents read_to_end(int fd, const std::string& name, const InputFile::SizeLimit& limit) {
    constexpr size_t kHead = 4096;  // as file.h says
    std::unique_ptr<std::byte, decltype(&std::free)> buffer(nullptr, &std::free);
    size_t size = 0, capacity = 0;
    uint64_t most = UINT64_MAX;
    bool is_limited = !limit;
    const auto ask_limit = [&] {
        is_limited = true;
        most = limit({buffer.get(), std::min(size, kHead)}, name);
    };
    while (size <= most) {
        if (size == capacity) {
            const size_t larger = capacity ? 2 * capacity : size_t{1} << 16;
            auto* moved = static_cast<std::byte*>(std::realloc(buffer.get(), larger));
            if (!moved) throw Error(text("%s: does not fit into memory after %zu bytes", name.c_str(), size));
            static_cast<void>(buffer.release());
            buffer.reset(moved);
            capacity = larger;
        }
        const ssize_t count = ::read(fd, buffer.get() + size, capacity - size);
        if (count == 0) break;
        if (count < 0) {
            if (errno == EINTR) continue;
            fail_with_errno(name, "cannot read");
        }
        size += static_cast<size_t>(count);
        if (!is_limited && size >= kHead) ask_limit();
    }
    if (!is_limited) ask_limit();
    return {buffer.release(), size};
}

}  // namespace

struct InputFile::State {
    std::byte* data = nullptr;
    size_t size = 0;
    bool mapped = false;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (mapped) {
            forget_mapping(data);
            ::munmap(data, size);
        } else {
            std::free(data);
        }
    }
};

namespace {

// -1 with errno set where there is no such file.
int open_input(const std::string& path) {
    return path == "-" ? ::dup(STDIN_FILENO) : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
}

}  // namespace

InputFile::InputFile(const std::string& path)
    : InputFile(Descriptor(open_input(path)).get(), path == "-" ? "standard input" : path) {}

InputFile::InputFile(const std::string& path, const SizeLimit& limit)
    : InputFile(Descriptor(open_input(path)).get(), path == "-" ? "standard input" : path, limit) {}

InputFile::InputFile(int fd, std::string name, const SizeLimit& limit)
    : state_(std::make_unique<State>()), name_(std::move(name)) {
    if (fd < 0) fail_with_errno(name_, "cannot open");
    struct stat status = {};
    if (::fstat(fd, &status) != 0) fail_with_errno(name_, "cannot read");
    if (S_ISDIR(status.st_mode)) throw Error(name_ + ": is a directory");
    // Files of /proc say 0 bytes and hold some; standard input may stand in the middle of a file.
    if (S_ISREG(status.st_mode) && status.st_size > 0 && ::lseek(fd, 0, SEEK_CUR) == 0) {
        const auto size = static_cast<size_t>(status.st_size);
        void* map = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (map != MAP_FAILED) {
            state_->data = static_cast<std::byte*>(map);
            state_->size = size;
            state_->mapped = true;
            watch_mapping(state_->data, size, name_, remove_temporaries);
        }
    }
    if (!state_->mapped) {
        const Contents contents = read_to_end(fd, name_, limit);
        state_->data = contents.data;
        state_->size = contents.size;
    }
    bytes_ = {state_->data, state_->size};
}

InputFile::~InputFile() = default;
InputFile::InputFile(InputFile&&) noexcept = default;
InputFile& InputFile::operator=(InputFile&&) noexcept = default;

void InputFile::forget(size_t begin, size_t end) const {
    if (!state_->mapped || end > state_->size) return;
    // Only whole pages: a page at the edge still holds bytes outside the range.
    const auto page = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
    begin = (begin + page - 1) / page * page;
    if (end != state_->size) end = end / page * page;
    if (begin < end) ::madvise(state_->data + begin, end - begin, MADV_DONTNEED);
}

struct OutputFile::State {
    Wanted wanted;
    std::string target;  // what the temporary file becomes; empty where it is written in place
    bool standard_output = false;
    bool committed = false;
    Temporary temporary;
    Descriptor fd;
    std::vector<std::byte> buffer;

    // Calls `write` until it finds the reader gone; from then on nothing is written.
    template <class Write>
    void while_wanted(const Write& write) {
        if (!wanted) return;
        while_others_wait([&] {
            try {
                write();
            } catch (const ClosedPipe&) {
                wanted.drop();
                throw;
            }
        });
    }

    void write(std::span<const std::byte> data, const std::string& name);
    void commit(const std::string& name);
};

OutputsToCome::OutputsToCome() {
    ++wanted_outputs;
}
OutputsToCome::~OutputsToCome() {
    --wanted_outputs;
}

namespace {

// Outputs are many small pieces (lines, blocks): one system call for about this many bytes.
constexpr size_t kBufferBytes = size_t{1} << 18;

// The file that `path` names after links, so that a link survives the renaming.
std::string resolved(const std::string& path) {
    const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
    return real ? std::string(real.get()) : path;
}

}  // namespace

OutputFile::OutputFile(const std::string& path)
    : state_(std::make_unique<State>()), name_(path == "-" ? kStandardOutput : path) {
    if (path == "-") {
        state_->standard_output = true;
        return;
    }
    struct stat status = {};
    const bool exists = ::stat(path.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) throw Error(name_ + ": is a directory");
    if (exists && !S_ISREG(status.st_mode)) {
        state_->fd.reset(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
        if (state_->fd.get() < 0) fail_with_errno(name_, "cannot open for writing");
        return;
    }
    // Renaming would replace a file that its owner has made read-only.
    if (exists && ::access(path.c_str(), W_OK) != 0) fail_with_errno(name_, "cannot open for writing");
    state_->target = exists ? resolved(path) : path;
    state_->fd.reset(state_->temporary.open(folder_of(state_->target)));
    if (state_->fd.get() < 0) {
        if (errno == ENOENT) throw Error(name_ + ": its folder is missing");
        fail_with_errno(name_, "cannot create a file there");
    }
}

OutputFile::OutputFile(const InMemory& file) : state_(std::make_unique<State>()), name_(file.name) {
    state_->fd.reset(::memfd_create("qs-tools", MFD_CLOEXEC));
    if (state_->fd.get() < 0) fail_with_errno(name_, "cannot be held in memory");
}

OutputFile::~OutputFile() {
    if (!state_->target.empty() && !state_->committed) state_->temporary.remove();
}

void OutputFile::State::write(std::span<const std::byte> data, const std::string& name) {
    if (standard_output)
        return put_to_standard_output({reinterpret_cast<const char*>(data.data()), data.size()}, false);
    if (buffer.size() + data.size() > kBufferBytes) {
        write_all(fd.get(), buffer, name);
        buffer.clear();
    }
    if (data.size() >= kBufferBytes) {
        write_all(fd.get(), data, name);
    } else {
        buffer.insert(buffer.end(), data.begin(), data.end());
    }
}

void OutputFile::State::commit(const std::string& name) {
    if (standard_output) return put_to_standard_output({}, true);
    write_all(fd.get(), buffer, name);
    buffer.clear();
    // Some file systems say only now that the disk is full.
    if (::close(fd.release()) != 0) fail_with_errno(name, "cannot write");
    if (target.empty()) return;
    if (::rename(temporary.path(), target.c_str()) != 0) {
        if (dying) wait_for_death();
        fail_with_errno(name, "cannot rename the finished file");
    }
    committed = true;
}

void OutputFile::write(std::span<const std::byte> data) {
    state_->while_wanted([&] { state_->write(data, name_); });
}

void OutputFile::write(std::string_view data) {
    write(data.data(), data.size());
}

void OutputFile::commit() {
    state_->while_wanted([&] { state_->commit(name_); });
}

InputFile OutputFile::read_back() {
    write_all(state_->fd.get(), state_->buffer, name_);
    state_->buffer.clear();
    if (::lseek(state_->fd.get(), 0, SEEK_SET) != 0) fail_with_errno(name_, "cannot read");
    return InputFile(state_->fd.get(), name_);
}

void write_standard_output(std::string_view data, bool flush) {
    while_others_wait([&] { put_to_standard_output(data, flush); });
}

namespace {

// What `path` names; "-" is the open file `standard`, if that keeps what is written.
bool find(const std::string& path, int standard, struct stat& status) {
    if (path != "-") return ::stat(path.c_str(), &status) == 0;
    return ::fstat(standard, &status) == 0 && S_ISREG(status.st_mode);
}

}  // namespace

bool same_file(const std::string& input, const std::string& output) {
    struct stat first = {}, second = {};
    return find(input, STDIN_FILENO, first) && find(output, STDOUT_FILENO, second) &&
           first.st_dev == second.st_dev && first.st_ino == second.st_ino;
}

std::string overwritten_file(const std::string& path) {
    struct stat status = {};
    if (path.empty()) return "";
    if ((path == "-" ? ::fstat(STDOUT_FILENO, &status) : ::stat(path.c_str(), &status)) == 0)
        return S_ISCHR(status.st_mode) ? std::string()
                                       : text("%llx:%llx", static_cast<unsigned long long>(status.st_dev),
                                              static_cast<unsigned long long>(status.st_ino));
    const std::string folder = folder_of(path);
    return resolved(folder.empty() ? "." : folder) + "/" + path.substr(folder.size());
}

void refuse_binary_to_terminal(bool spelled_out) {
    if (!spelled_out && ::isatty(STDOUT_FILENO))
        throw UsageError("standard output is a terminal; name a file with -o, or spell out '-o -'");
}

}  // namespace core
