#include "fetch/unix_socket.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>

#include "fetch/messages.h"

namespace fetch {

namespace {

constexpr int kType = SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC;
constexpr size_t kMostDescriptors = 3;

sockaddr_un address_in(int folder) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/%s", folder, kSocketName);
    return address;
}

Descriptor make_socket() {
    Descriptor socket(::socket(AF_UNIX, kType, 0));
    if (!socket) fail_with_errno("socket", "cannot be made");
    return socket;
}

}  // namespace

Descriptor listen_in(int folder, const std::string& path) {
    const std::string name = path + "/" + kSocketName;
    Descriptor socket = make_socket();
    const sockaddr_un address = address_in(folder);
    ::unlinkat(folder, kSocketName, 0);
    if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        fail_with_errno(name, "cannot make the socket");
    if (::listen(socket.get(), SOMAXCONN) != 0) fail_with_errno(name, "cannot listen");
    return socket;
}

Descriptor connect_to(int folder, const std::string& path) {
    Descriptor socket = make_socket();
    const sockaddr_un address = address_in(folder);
    if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
        return socket;
    // EAGAIN: more are waiting to be let in than the system queues.
    if (errno == ENOENT || errno == ECONNREFUSED || errno == EAGAIN) return Descriptor();
    fail_with_errno(path + "/" + kSocketName, "cannot connect");
}

unsigned peer_of(int socket) {
    ucred peer = {};
    socklen_t size = sizeof peer;
    if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
        fail_with_errno("socket", "cannot tell its user");
    return peer.uid;
}

bool send_message(int socket, std::span<const std::byte> message, std::span<const int> descriptors) {
    iovec bytes{const_cast<std::byte*>(message.data()), message.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(kMostDescriptors * sizeof(int))> control = {};
    msghdr header = {};
    header.msg_iov = &bytes;
    header.msg_iovlen = 1;
    if (!descriptors.empty()) {
        header.msg_control = control.data();
        header.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
        cmsghdr* const rights = CMSG_FIRSTHDR(&header);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(descriptors.size_bytes());
        std::memcpy(CMSG_DATA(rights), descriptors.data(), descriptors.size_bytes());
    }
    for (;;) {
        if (::sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return true;
        if (errno == EINTR) continue;
        // ETOOMANYREFS: the other end has left too many descriptors lying.
        if (errno == EAGAIN || errno == ENOBUFS || errno == ETOOMANYREFS) return false;
        fail_with_errno("socket", "cannot send");
    }
}

bool receive_message(int socket, size_t most_descriptors, Received& received) {
    received = Received();
    received.message.resize(kMostMessageBytes);
    iovec bytes{received.message.data(), received.message.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(kMostDescriptors * sizeof(int))> control = {};
    msghdr header = {};
    header.msg_iov = &bytes;
    header.msg_iovlen = 1;
    if (most_descriptors > 0) {
        header.msg_control = control.data();
        header.msg_controllen = CMSG_SPACE(std::min(most_descriptors, kMostDescriptors) * sizeof(int));
    }
    ssize_t size = -1;
    do {
        size = ::recvmsg(socket, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    } while (size < 0 && errno == EINTR);
    if (size < 0 && errno == EAGAIN) return false;
    if (size < 0 && errno != ECONNRESET) fail_with_errno("socket", "cannot receive");
    for (cmsghdr* part = CMSG_FIRSTHDR(&header); size > 0 && part; part = CMSG_NXTHDR(&header, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
        for (size_t at = 0; at + sizeof(int) <= part->cmsg_len - CMSG_LEN(0); at += sizeof(int)) {
            int fd = -1;
            std::memcpy(&fd, CMSG_DATA(part) + at, sizeof fd);
            received.descriptors.emplace_back(fd);
        }
    }
    if (header.msg_flags & MSG_TRUNC) throw core::Error("a message is longer than 64 KiB");
    received.is_closed = size <= 0;
    received.message.resize(size > 0 ? size_t(size) : 0);
    return true;
}

}  // namespace fetch
