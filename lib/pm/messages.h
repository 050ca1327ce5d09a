// What a client and a server of progressive meshes say to each other.  man/pm-protocol.5 is the
// specification.
//
// Messages are the bodies of frames (net/frames.h), little-endian, and begin with their kind, a byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pm/format.h"
#include "pm/service.h"
#include "pm/view.h"

namespace pm {

constexpr uint16_t kProtocolVersion = 1;
constexpr size_t kMostNameBytes = 1024;
constexpr uint32_t kMostDecisions = 4096;             // of a packet
constexpr size_t kMostServerMessageBytes = 64 << 20;  // a base mesh may be large

enum class RequestKind : uint8_t { open = 1, resume, view, status, catalogue, list };
enum class ReplyKind : uint8_t { opened = 129, resumed, packet, failed, answer };

struct Request {
    RequestKind kind = RequestKind::open;
    std::string name;  // open, resume: of the model
    Service service = Service::selective;
    uint64_t hash = 0;             // resume: model_hash() of what the client has
    std::vector<std::byte> bytes;  // resume: encode_record(); list: make_list()
    uint32_t number = 0;           // view, list: greater than that of the one before
    View view;
    Culling culling = Culling::on;
};

struct Reply {
    ReplyKind kind = ReplyKind::failed;
    std::array<std::byte, kHeaderSize> header{};  // opened: of the model's file
    std::vector<std::byte> bytes;                 // opened: encode_base(); packet: the coded decisions
    uint32_t splits = 0;                          // resumed: which the client has
    uint32_t view = 0;                            // packet: what it answers
    bool is_first = false;                        // packet: the answer begins (again)
    bool is_last = false;                         // packet: it ends
    uint16_t decisions = 0, check = 0;
    std::string text;  // failed: why; answer: JSON
};

std::vector<std::byte> to_bytes(const Request& request);
std::vector<std::byte> to_bytes(const Reply& reply);

// Throw core::Error where the bytes are no message, or are one of another version; views are checked
// (view.h).
Request parse_request(std::span<const std::byte> bytes);
Reply parse_reply(std::span<const std::byte> bytes);

}  // namespace pm
