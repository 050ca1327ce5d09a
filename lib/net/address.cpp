#include "net/address.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "net/socket_address.h"

namespace net {

namespace {

constexpr int kType = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;

// True when it is connected; errno says why not.
bool connect_within(int socket, const SocketAddress& to, double timeout_s) {
    if (::connect(socket, to.get(), to.size) == 0) return true;
    if (errno != EINPROGRESS) return false;
    pollfd waiting{socket, POLLOUT, 0};
    const int ms = int(std::clamp(std::ceil(timeout_s * 1000), 0.0, 3'600'000.0));
    if (::poll(&waiting, 1, ms) <= 0) {
        errno = ETIMEDOUT;
        return false;
    }
    socklen_t size = sizeof errno;
    int reason = 0;
    ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &reason, &size);
    errno = reason;
    return reason == 0;
}

}  // namespace

Address parse_address(const std::string& text) {
    const auto fail = [&] {
        return core::UsageError("'" + text +
                                "' is no address; give HOST:PORT, as in 127.0.0.1:4100, or the path of a "
                                "Unix socket, as in /run/user/1000/pm.socket");
    };
    const std::string scheme = "unix:";
    if (text.starts_with(scheme) || text.find('/') != std::string::npos) {
        Address address;
        address.path = text.starts_with(scheme) ? text.substr(scheme.size()) : text;
        if (address.path.empty()) throw fail();
        unix_address(address.path);  // throws for one that is too long
        return address;
    }
    const size_t colon = text.rfind(':');
    if (colon == std::string::npos) throw fail();
    Address address;
    address.host = text.substr(0, colon);
    const char *const begin = text.data() + colon + 1, *const end = text.data() + text.size();
    const auto parsed = std::from_chars(begin, end, address.port);
    if (parsed.ec != std::errc() || parsed.ptr != end) throw fail();
    if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']')
        address.host = address.host.substr(1, address.host.size() - 2);
    else if (address.host.find(':') != std::string::npos)
        throw fail();
    if (address.host.empty()) address.host = "127.0.0.1";
    return address;
}

std::string to_text(const Address& address) {
    if (address.is_unix()) return address.path;
    const bool is_v6 = address.host.find(':') != std::string::npos;
    return (is_v6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

core::Descriptor connect_to(const Address& address, double timeout_s) {
    const std::string name = to_text(address);
    int reason = 0;
    for (const SocketAddress& to : resolve(address, 0)) {
        core::Descriptor socket(::socket(to.get()->sa_family, kType, 0));
        if (!socket) core::fail_with_errno(name, "cannot connect");
        if (connect_within(socket.get(), to, timeout_s)) {
            // What is sent is small and answers something: it never waits for more.
            const int on = 1;
            if (!address.is_unix()) ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            return socket;
        }
        reason = errno;
    }
    throw CannotConnect(name + ": cannot connect: " + std::strerror(reason));
}

}  // namespace net
