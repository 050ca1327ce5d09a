#include "net/socket_address.h"

#include <netdb.h>
#include <sys/un.h>

#include <array>
#include <charconv>
#include <memory>

namespace net {

SocketAddress unix_address(const std::string& path) {
    sockaddr_un address = {};
    if (path.size() >= sizeof address.sun_path)
        throw core::UsageError(path + ": the path of a Unix socket has at most 107 bytes");
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, path.size());
    SocketAddress result;
    std::memcpy(&result.storage, &address, sizeof address);
    result.size = sizeof address;
    return result;
}

std::vector<SocketAddress> resolve(const Address& address, int flags) {
    if (address.is_unix()) return {unix_address(address.path)};
    addrinfo wanted = {};
    wanted.ai_socktype = SOCK_STREAM;
    wanted.ai_flags = flags | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    const std::string port = std::to_string(address.port);
    const int failed = ::getaddrinfo(address.host.c_str(), port.c_str(), &wanted, &found);
    if (failed != 0) throw core::Error(to_text(address) + ": cannot be found: " + ::gai_strerror(failed));
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> keeper(found, ::freeaddrinfo);
    std::vector<SocketAddress> all;
    for (const addrinfo* one = found; one; one = one->ai_next) {
        all.emplace_back();
        std::memcpy(&all.back().storage, one->ai_addr, one->ai_addrlen);
        all.back().size = one->ai_addrlen;
    }
    return all;
}

std::string name_of(int socket) {
    SocketAddress bound;
    bound.size = sizeof bound.storage;
    if (::getsockname(socket, reinterpret_cast<sockaddr*>(&bound.storage), &bound.size) != 0)
        core::fail_with_errno("socket", "cannot tell its address");
    if (bound.storage.ss_family == AF_UNIX) {
        sockaddr_un address = {};
        std::memcpy(&address, &bound.storage, std::min<size_t>(bound.size, sizeof address));
        return address.sun_path;
    }
    std::array<char, NI_MAXHOST> host = {};
    std::array<char, NI_MAXSERV> port = {};
    if (::getnameinfo(bound.get(), bound.size, host.data(), host.size(), port.data(), port.size(),
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        throw core::Error("socket: cannot tell its address");
    Address address;
    address.host = host.data();
    std::from_chars(port.data(), port.data() + port.size(), address.port);
    return to_text(address);
}

}  // namespace net
