#include "net/listener.h"

#include <fcntl.h>
#include <netdb.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cstdlib>
#include <string_view>

#include "net/socket_address.h"

namespace net {

namespace {

constexpr int kType = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;

bool somebody_listens(const SocketAddress& address) {
    const core::Descriptor socket(::socket(AF_UNIX, kType, 0));
    return ::connect(socket.get(), address.get(), address.size) == 0 || errno == EAGAIN;
}

bool is_socket(const std::string& path) {
    struct stat status = {};
    return ::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
}

core::Descriptor bind_unix(const Address& address) {
    const SocketAddress to = unix_address(address.path);
    core::Descriptor socket(::socket(AF_UNIX, kType, 0));
    if (!socket) core::fail_with_errno(address.path, "cannot make the socket");
    ::fchmod(socket.get(), 0600);  // which bind() gives to the file
    if (::bind(socket.get(), to.get(), to.size) == 0) return socket;
    if (errno == EADDRINUSE && is_socket(address.path) && !somebody_listens(to)) {
        ::unlink(address.path.c_str());
        if (::bind(socket.get(), to.get(), to.size) == 0) return socket;
    }
    core::fail_with_errno(address.path, "cannot make the socket");
}

core::Descriptor bind_tcp(const Address& address) {
    const SocketAddress to = resolve(address, AI_PASSIVE).front();
    core::Descriptor socket(::socket(to.get()->sa_family, kType, 0));
    if (!socket) core::fail_with_errno(to_text(address), "cannot make a socket");
    // A server that is started again need not wait until the system has forgotten its old connections.
    const int on = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (::bind(socket.get(), to.get(), to.size) != 0)
        core::fail_with_errno(to_text(address), "cannot listen there");
    return socket;
}

}  // namespace

core::Descriptor inherited_socket(int type) {
    const char* const pid = std::getenv("LISTEN_PID");
    const char* const count = std::getenv("LISTEN_FDS");
    if (!pid || !count || pid != std::to_string(::getpid())) return core::Descriptor();
    if (std::string_view(count) != "1") throw core::Error("LISTEN_FDS: is not 1; one socket is listened on");
    core::Descriptor socket(3);
    int is_of_type = 0, listens = 0;
    socklen_t size = sizeof(int);
    const auto ask = [&](int option, int& value) {
        return ::getsockopt(socket.get(), SOL_SOCKET, option, &value, &size) == 0;
    };
    if (!ask(SO_TYPE, is_of_type) || !ask(SO_ACCEPTCONN, listens) || is_of_type != type || listens == 0)
        throw core::Error(
            std::string("LISTEN_FDS: the socket is no listening one of ") +
            (type == SOCK_STREAM ? "streams (ListenStream)" : "messages (ListenSequentialPacket)"));
    ::fcntl(socket.get(), F_SETFL, O_NONBLOCK);
    ::fcntl(socket.get(), F_SETFD, FD_CLOEXEC);
    return socket;
}

void allow_many_descriptors() {
    rlimit limit = {};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

Listener::Listener(const Address& address)
    : socket_(address.is_unix() ? bind_unix(address) : bind_tcp(address)),
      is_to_be_removed_(address.is_unix()) {
    if (::listen(socket_.get(), SOMAXCONN) != 0)
        core::fail_with_errno(to_text(address), "cannot listen there");
    name_ = name_of(socket_.get());
}

Listener::Listener(core::Descriptor socket) : socket_(std::move(socket)), name_(name_of(socket_.get())) {}

Listener::~Listener() {
    if (socket_ && is_to_be_removed_) ::unlink(name_.c_str());
}

}  // namespace net
