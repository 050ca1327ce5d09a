// What client and server say to each other, as bytes: see ppve-protocol(5).
//
// Who frames the messages (a length before each) is not told here: parse() gets one whole message.  Every
// message ends with a checksum of its bytes.
//
// Both sides hold the same octree of points (octree.h), changed by answers alone, in their order: an answer
// first deletes the leaves that it names, then replaces, then inserts its image's samples.  A client that
// wants to be rid of leaves asks for it, keeps them until an answer deletes them, and so cannot be out of
// step by itself.  Each answer carries the checksum of the octree after it; a client that comes to another
// one says so in its next request, and the next answer starts anew with an empty octree.
//
// The paper, sections 4.3 to 4.5 and 5.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "ppve/codec.h"
#include "ppve/depth_image.h"
#include "ppve/sampler.h"

namespace ppve {

constexpr uint16_t kProtocolVersion = 1;
constexpr uint64_t kMostMessageBytes = uint64_t(1) << 30;
constexpr uint32_t kMostDeletions = 1u << 16;  // leaves in one message
constexpr size_t kMostText = 1024;             // bytes of a name or a reason
constexpr size_t kMostCounters = 1u << 16;     // bytes of a server's counters

// How what the client has already is left out.
enum class Elimination : uint8_t {
    none = 0,      // all samples are sent
    paper = 1,     // the paper's rule, section 4.2, with a constant epsilon
    filtered = 2,  // coarse points left out of the reference; epsilon: footprint + slope; replacement
};

// Server to client, first of all.
struct Welcome {
    uint16_t version = kProtocolVersion;
    Box bounds{};              // of the scene: the octree's root is made of it, on both sides alike
    uint64_t most_pixels = 0;  // of a request
    uint64_t most_points = 0;  // that the server keeps for this client; it deletes leaves beyond
    std::string scene;         // a name to show
    std::string sampler;
    bool operator==(const Welcome&) const = default;
};

// Client to server: sample this.
struct Request {
    uint64_t id = 0;     // counted up by the client; larger than that of the request before
    uint64_t stamp = 0;  // comes back in the answer: the time it is for, say
    Frustum frustum{};
    double footprint_px = 1;  // see DepthImage; in (0, 16]
    double bound_px = 0.01;   // of depth errors; 0: as single-precision floats
    Codec codec = Codec::planes;
    Elimination elimination = Elimination::filtered;
    double epsilon = 0;  // paper: world units
    bool wants_normals = false;
    // What the client holds: the last answer that it took (0: none), and its octree's checksum then.
    uint64_t last_answer = 0;
    uint64_t octree_checksum = 0;
    std::vector<uint64_t> deletions;  // leaves to be deleted, octree numbers
};

// Client to server: delete these leaves, there is no request with it.
struct Deletions {
    std::vector<uint64_t> leaves;
    bool operator==(const Deletions&) const = default;
};

// Server to client: the samples of one request.
struct Answer {
    uint64_t id = 0, stamp = 0;     // those of the request
    bool starts_anew = false;       // the client empties its octree first
    std::vector<uint64_t> deleted;  // leaves; those that are not there are skipped
    std::vector<std::byte>
        replaced;       // points of older answers that are deleted, as elimination.h writes them
    Frustum frustum{};  // the request's: an answer can be read without it, from a recording, say
    DepthCoding coding{};
    double footprint_px = 1;
    bool has_normals = false;
    Codec codec = Codec::planes;
    std::vector<std::byte> image;  // by encode(); depths of what is left out are 0
    uint64_t octree_checksum = 0;  // after this answer
    // What it cost the server, for reports.
    uint64_t samples = 0, samples_kept = 0;
    SampleCounts counts{};
    float sample_ms = 0, eliminate_ms = 0, encode_ms = 0;
};

// Client to server: say what you have counted.
struct StatusQuery {
    bool operator==(const StatusQuery&) const = default;
};

// Server to client: an object of JSON, status.h.
struct Status {
    std::string counters;
    bool operator==(const Status&) const = default;
};

// Server to client: a request that is not answered, and why.  The connection stays.
struct Refusal {
    uint64_t id = 0;
    std::string reason;
    bool operator==(const Refusal&) const = default;
};

using Message = std::variant<Welcome, Request, Deletions, Answer, Refusal, StatusQuery, Status>;

std::vector<std::byte> format(const Message& message);

// Throws core::Error "<from>: ..." for anything that format() does not write: cut off, a wrong checksum, an
// unknown type, numbers out of range, a frustum that check() refuses.  What is allocated is bounded by the
// message's length.
Message parse(std::span<const std::byte> bytes, const std::string& from);

// The image that an answer carries, decoded.
DepthImage image_of(const Answer& answer);

}  // namespace ppve
