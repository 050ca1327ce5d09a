#include "fetch/client.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>

#include "fetch/private_folder.h"
#include "fetch/unix_socket.h"
#include "net/event_loop.h"

extern char** environ;

namespace fetch {

namespace {

constexpr double kAnswerTimeout = 60;
constexpr uint64_t kLeastBlockBytes = 512;

bool wait_for(int fd, short events, double seconds) {
    pollfd waiting{fd, events, 0};
    const double ms = std::clamp(std::ceil(seconds * 1000), 0.0, 3'600'000.0);
    return ::poll(&waiting, 1, int(ms)) > 0;
}

// In a session of its own, so that a Ctrl-C in the terminal of this program does not end what others use.
pid_t start_daemon(const ClientOptions& options) {
    std::vector<std::string> words = {options.program, "serve", "--cache", options.folder,
                                      "--idle-exit",   "30s",   "--quiet"};
    words.insert(words.end(), options.daemon_arguments.begin(), options.daemon_arguments.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
    pid_t pid = -1;
    const int failed =
        ::posix_spawnp(&pid, options.program.c_str(), &files, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed != 0) throw core::Error(options.program + ": cannot be started: " + std::strerror(failed));
    return pid;
}

bool is_note(Reason reason) {
    return reason == Reason::renewed || reason == Reason::unchecked;
}

uint64_t length_of(int fd) {
    struct stat status = {};
    return ::fstat(fd, &status) == 0 ? uint64_t(status.st_size) : 0;
}

}  // namespace

// ---- RemoteFile ----

RemoteFile::~RemoteFile() {
    connection_.files_.erase(stream_);
    try {
        Request request;
        request.kind = RequestKind::close;
        request.stream = stream_;
        connection_.send(request);
    } catch (const core::Error&) {
        // The daemon has gone, and with it what was to be closed.
    }
}

std::span<const std::byte> RemoteFile::block(uint32_t index) const {
    const uint64_t begin = uint64_t{index} * block_bytes_;
    const std::atomic_ref use(reinterpret_cast<uint32_t*>(use_.data())[begin / kChunkBytes]);
    // Written before the look at the state, see block_map.h; and once a second only, for the others who read
    // it.
    const uint32_t now = use_clock();
    if (use.load(std::memory_order_seq_cst) != now) use.exchange(now, std::memory_order_seq_cst);
    if (states_.get(index) != BlockState::present) return {};
    return {data_.data() + begin, size_t(std::min<uint64_t>(block_bytes_, bytes_ - begin))};
}

bool RemoteFile::want(std::vector<Want> wants) {
    if (wants.size() > kMostWants) {
        const auto is_sooner = [](const Want& a, const Want& b) { return a.priority > b.priority; };
        std::nth_element(wants.begin(), wants.begin() + kMostWants, wants.end(), is_sooner);
        wants.resize(kMostWants);
    }
    Request request;
    request.kind = RequestKind::want;
    request.stream = stream_;
    request.wants = std::move(wants);
    return connection_.send(request);
}

// The daemon is this user's own, but its bytes are checked all the same: a map must not reach beyond its
// file.
void RemoteFile::take_opened(const Reply& reply, std::vector<Descriptor>& descriptors) {
    bytes_ = reply.file_bytes;
    block_bytes_ = reply.block_bytes;
    const bool is_sound = bytes_ > 0 && bytes_ <= kMostFileBytes && block_bytes_ >= kLeastBlockBytes &&
                          kChunkBytes % block_bytes_ == 0 && descriptors.size() == 3;
    if (!is_sound || length_of(descriptors[0].get()) != bytes_ ||
        length_of(descriptors[1].get()) != map_bytes(block_count()) ||
        length_of(descriptors[2].get()) != use_bytes(bytes_))
        throw core::Error("the daemon passed files that do not fit together");
    data_ = FileMap(descriptors[0].get(), size_t(bytes_), false, "cached data");
    map_ = FileMap(descriptors[1].get(), map_bytes(block_count()), false, "availability map");
    use_ = FileMap(descriptors[2].get(), use_bytes(bytes_), true, "use map");
    states_ = BlockStates(map_.data());
    is_open_ = true;
}

// ---- Connection ----

Connection::Connection(const ClientOptions& options) : folder_(options.folder) {
    connect(options);
}

Connection::~Connection() = default;

void Connection::connect(const ClientOptions& options) {
    const Descriptor folder = open_private_folder(options.folder);
    const double until = net::steady_seconds() + options.start_timeout_s;
    pid_t child = -1;
    int status = 0;
    for (;;) {
        socket_ = connect_to(folder.get(), options.folder);
        if (socket_) return;
        if (options.program.empty()) throw core::Error(options.folder + ": no qs-fetch runs here");
        if (child < 0) child = start_daemon(options);
        // One that another program started at the same time may hold the folder; then it answers soon.
        ::waitpid(child, &status, WNOHANG);
        if (net::steady_seconds() > until)
            throw core::Error(options.folder + ": qs-fetch does not start; 'qs-fetch serve' says why");
        ::poll(nullptr, 0, 5);
    }
}

bool Connection::send(const Request& request) {
    return send_message(socket_.get(), to_bytes(request), {});
}

void Connection::send_surely(const Request& request) {
    const double until = net::steady_seconds() + kAnswerTimeout;
    while (!send(request))
        if (!wait_for(socket_.get(), POLLOUT, until - net::steady_seconds()))
            throw core::Error(folder_ + ": qs-fetch does not answer");
}

void Connection::take(const Reply& reply, std::vector<Descriptor>& descriptors) {
    if (reply.kind == ReplyKind::answer) {
        answer_ = reply;
        has_answer_ = true;
        return;
    }
    const auto found = files_.find(reply.stream);
    if (found == files_.end()) return;
    RemoteFile& file = *found->second;
    switch (reply.kind) {
        case ReplyKind::opened:
            if (!file.is_open_) file.take_opened(reply, descriptors);
            return;
        case ReplyKind::ended:
            file.failure_ = reply.text;
            file.is_replaced_ = reply.reason == Reason::replaced;
            return;
        case ReplyKind::trouble:
            (is_note(reply.reason) ? file.note_ : file.trouble_) = reply.text;
            return;
        case ReplyKind::arrived:
            file.trouble_.clear();
            return;
        default:
            return;
    }
}

// What has come, without waiting.
bool Connection::take_messages() {
    bool has_come = false;
    Received received;
    while (receive_message(socket_.get(), 3, received)) {
        // What it said before it ended is heard first.
        if (received.is_closed && has_come) return true;
        if (received.is_closed) throw core::Error(folder_ + ": qs-fetch has ended");
        take(parse_reply(received.message), received.descriptors);
        has_come = true;
    }
    return has_come;
}

bool Connection::wait(double timeout_s) {
    if (take_messages()) return true;
    return wait_for(socket_.get(), POLLIN, timeout_s) && take_messages();
}

std::unique_ptr<RemoteFile> Connection::open(const std::string& url, double timeout_s) {
    std::unique_ptr<RemoteFile> file(new RemoteFile(*this, next_stream_++));
    Request request;
    request.kind = RequestKind::open;
    request.stream = file->stream_;
    request.url = url;
    if (url.size() > kMostMessageBytes / 2) throw core::Error("the URL is too long");
    files_[file->stream_] = file.get();
    send_surely(request);
    const double until = net::steady_seconds() + timeout_s;
    while (!file->is_open_ && file->failure_.empty()) {
        const double left = until - net::steady_seconds();
        if (left <= 0 || (!wait(left) && net::steady_seconds() >= until))
            throw core::Error(
                url + (file->trouble_.empty() ? ": the server does not answer" : ": " + file->trouble_));
    }
    if (!file->is_open_) throw core::Error(url + ": " + file->failure_);
    return file;
}

std::string Connection::ask(const Request& request) {
    has_answer_ = false;
    send_surely(request);
    const double until = net::steady_seconds() + kAnswerTimeout;
    while (!has_answer_) {
        if (net::steady_seconds() >= until) throw core::Error(folder_ + ": qs-fetch does not answer");
        wait(until - net::steady_seconds());
    }
    if (!answer_.is_right) throw core::Error(answer_.text);
    return answer_.text;
}

std::string Connection::status() {
    Request request;
    request.kind = RequestKind::status;
    return ask(request);
}

std::string Connection::evict(uint64_t keep_bytes, const std::string& url) {
    Request request;
    request.kind = RequestKind::evict;
    request.keep_bytes = keep_bytes;
    request.url = url;
    return ask(request);
}

void Connection::stop() {
    Request request;
    request.kind = RequestKind::stop;
    ask(request);
    // Until it has let go of the folder, so that the next one can start.
    try {
        while (wait(kAnswerTimeout)) {
        }
    } catch (const core::Error&) {
    }
}

}  // namespace fetch
