// The header fields of an answer to a range request, as far as they say which bytes of which version came.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "fetch/store.h"

namespace fetch {

// "Content-Range: bytes FIRST-LAST/TOTAL" of a part, or "bytes */TOTAL" of a refusal, which has no bytes.
struct ContentRange {
    bool has_bytes = false;
    uint64_t first = 0, last = 0;
    uint64_t total = 0;
};
// Nothing where the text is anything else, an unknown total ("*") and LAST beyond TOTAL among it.
std::optional<ContentRange> parse_content_range(std::string_view value);

// Seconds to wait, from "Retry-After: 120" or a date, at most kMostRetrySeconds; `now_s` is the time of the
// same clock as the date: the server's, where it says ("Date"), since ours may be years off.  Nothing where
// it is neither.
constexpr int64_t kMostRetrySeconds = 300;
std::optional<int64_t> parse_retry_after(std::string_view value, int64_t now_s);

// What is kept of the fields of one answer.
struct HttpFields {
    int status = 0;
    std::optional<ContentRange> content_range;
    bool has_bad_content_range = false;
    bool is_multipart = false;
    std::string content_encoding;  // empty for none and for identity
    Validator validator;
    std::optional<int64_t> retry_after_s;
    std::string retry_after;        // as it came
    std::optional<int64_t> date_s;  // of the server's clock

    // Takes a line of a header, with or without its end.  A status line starts anew (after a redirect).
    void take_line(std::string_view line, int64_t now_s);
};

// The validator that If-Range may name: a strong entity tag, else the time of modification.  Empty for none.
std::string strong_validator(const Validator& validator);

}  // namespace fetch
