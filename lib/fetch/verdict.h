// What the header of an answer to a range request says: that the bytes asked for come, or why not.
//
// What is checked: the status; that Content-Range begins where it was asked to and ends no later; that the
// length of the body is that of the range; that nothing is encoded; that entity tag, time of modification and
// total size are those of the first answer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fetch/http_fields.h"
#include "fetch/store.h"

namespace fetch {

struct RangeRequest {
    std::string url;
    uint64_t first = 0, last = 0;  // bytes, both included
    uint64_t total = 0;            // of the first answer; 0: this is the first
    Validator validator;           // of the first answer
    bool may_send_if_range = true;
    // Asks whether the server still has the version that `total` and `validator` name; bytes come only where
    // it cannot say so without them.
    bool is_check = false;

    // The header line that makes it conditional; empty where nothing does.
    std::string condition() const;
};

struct RangeEnd {
    enum class Verdict {
        done,
        retry,        // this time it did not work; what has come is right
        busy,         // the server asks to be left alone for a while
        refused,      // it will not work the next time either
        no_ranges,    // the server sends whole files only
        no_if_range,  // the server sends the whole of this very version: ask again without If-Range
        changed,      // the server has another version of the file
        unchanged,    // to a check: the server has the same version
    };
    Verdict verdict = Verdict::done;
    std::string reason;         // without the URL: "server answered 404"; empty for done
    double retry_after_s = -1;  // what the server asked for; negative: nothing
    unsigned streams = 0;       // requests that may run on the server's connections at a time; 0: not known
    unsigned connections = 0;   // that these are spread over; 0: not known
};

struct Judgement {
    bool is_accepted = false;
    uint64_t expected = 0;  // where it is accepted: bytes of the body
    RangeEnd end;           // where it is not
};

// `length`: that of the body, where the header tells.
Judgement judge(const RangeRequest& request, const HttpFields& fields, std::optional<uint64_t> length);

}  // namespace fetch
