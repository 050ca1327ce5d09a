// What a client and the daemon say to each other, over a Unix socket that keeps messages apart
// (SOCK_SEQPACKET).
//
// A message is at most kMostMessageBytes, little-endian, its kind first.  A stream is the client's number for
// a file that it has open.  The client:
//
//     open    kind, version, stream, URL          want    kind, stream, (block, priority as float)...
//     close   kind, stream                        status  kind
//     evict   kind, bytes to leave (64 bits), URL; without one, of all files
//     stop    kind
//
// want takes the place of the stream's earlier one.  The daemon:
//
//     opened  kind, stream, file's bytes (64 bits), block bytes; with descriptors of data, map and use map
//     arrived kind, stream: a block of the last want is there; once for each want
//     ended   kind, stream, reason, text: nothing more will come of this stream
//     trouble kind, stream, reason, text: it is being tried again; before opened, with the reasons renewed
//     and
//             unchecked, what is to be known about the version that opens
//     answer  kind, is_right, text: to status, evict, stop; JSON, or why not
//
// Numbers are 32 bits where nothing is said.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fetch/request_queue.h"

namespace fetch {

constexpr size_t kMostMessageBytes = 64 * 1024;
constexpr size_t kMostWants = 8000;  // in one message
constexpr uint32_t kMessageVersion = 1;
constexpr const char* kSocketName = "socket";  // in the folder of the cache

enum class RequestKind : uint32_t { open = 1, want, close, status, evict, stop };
enum class ReplyKind : uint32_t { opened = 101, arrived, ended, trouble, answer };
enum class Reason : uint32_t { failed, replaced, full, renewed, unchecked };

struct Request {
    RequestKind kind = RequestKind::status;
    uint32_t stream = 0;
    std::string url;
    std::vector<Want> wants;
    uint64_t keep_bytes = 0;
};

struct Reply {
    ReplyKind kind = ReplyKind::answer;
    uint32_t stream = 0;
    uint64_t file_bytes = 0;
    uint32_t block_bytes = 0;
    Reason reason = Reason::failed;
    bool is_right = false;
    std::string text;
};

std::vector<std::byte> to_bytes(const Request& request);
std::vector<std::byte> to_bytes(const Reply& reply);

// Throw core::Error where the bytes are no message; priorities are finite and not negative.
Request parse_request(std::span<const std::byte> bytes);
Reply parse_reply(std::span<const std::byte> bytes);

}  // namespace fetch
