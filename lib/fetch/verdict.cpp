#include "fetch/verdict.h"

namespace fetch {

namespace {

using Verdict = RangeEnd::Verdict;

constexpr unsigned long long as_llu(uint64_t n) {
    return n;
}

Judgement refused(std::string reason) {
    return {false, 0, {Verdict::refused, std::move(reason)}};
}

bool is_known_and_other(const std::string& before, const std::string& now) {
    return !before.empty() && !now.empty() && before != now;
}

bool is_other_version(const Validator& before, const Validator& now) {
    return is_known_and_other(before.etag, now.etag) ||
           is_known_and_other(before.last_modified, now.last_modified);
}

std::string asked_for(const RangeRequest& request) {
    return core::text("asked for bytes %llu-%llu, ", as_llu(request.first), as_llu(request.last));
}

RangeEnd of_whole_file(const RangeRequest& request, const HttpFields& fields,
                       std::optional<uint64_t> length) {
    const bool is_other = is_other_version(request.validator, fields.validator) ||
                          (length && request.total > 0 && *length != request.total);
    if (is_other && request.total > 0) return {Verdict::changed, "the file has changed at the server"};
    if (request.is_check) return {Verdict::unchanged, ""};
    // An answer to If-Range may be that the file has changed, or that the server does not trust the
    // validator.
    if (request.total > 0 && !request.condition().empty())
        return {Verdict::no_if_range, "server does not compare what it sent before"};
    return {Verdict::no_ranges,
            asked_for(request) + "server sent 200 without ranges; others do better, see qs-hosting(7)"};
}

RangeEnd of_status(const RangeRequest& request, const HttpFields& fields, std::optional<uint64_t> length) {
    const int status = fields.status;
    if (status == 200) return of_whole_file(request, fields, length);
    if (status == 304 && request.is_check) return {Verdict::unchanged, ""};
    if (status == 416) {
        if (request.total > 0) return {Verdict::changed, "the file has become shorter at the server"};
        const bool is_empty = fields.content_range && fields.content_range->total == 0;
        return {Verdict::refused,
                is_empty ? "the file is empty" : asked_for(request) + "server answered 416"};
    }
    RangeEnd answer{Verdict::refused, core::text("server answered %d", status)};
    const bool is_busy = status == 429 || (status == 503 && fields.retry_after_s);
    if (is_busy)
        answer.verdict = Verdict::busy;
    else if (status >= 500 || status == 408 || status == 425)
        answer.verdict = Verdict::retry;
    if (fields.retry_after_s) answer.retry_after_s = double(*fields.retry_after_s);
    return answer;
}

}  // namespace

std::string RangeRequest::condition() const {
    if (is_check) {
        if (!validator.etag.empty()) return "If-None-Match: " + validator.etag;
        if (!validator.last_modified.empty()) return "If-Modified-Since: " + validator.last_modified;
        return "";
    }
    const std::string strong = strong_validator(validator);
    return may_send_if_range && !strong.empty() ? "If-Range: " + strong : "";
}

Judgement judge(const RangeRequest& request, const HttpFields& fields, std::optional<uint64_t> length) {
    if (fields.status != 206) return {false, 0, of_status(request, fields, length)};
    if (!fields.content_encoding.empty())
        return refused(asked_for(request) + "server sent them encoded as " + fields.content_encoding);
    if (fields.is_multipart) return refused(asked_for(request) + "server sent several parts");
    if (fields.has_bad_content_range || !fields.content_range || !fields.content_range->has_bytes)
        return refused(asked_for(request) +
                       "server sent 206 without a Content-Range that says which and of how many");
    const ContentRange& range = *fields.content_range;
    if (range.first != request.first || range.last > request.last)
        return refused(asked_for(request) +
                       core::text("server sent bytes %llu-%llu", as_llu(range.first), as_llu(range.last)));
    if (request.total > 0 &&
        (range.total != request.total || is_other_version(request.validator, fields.validator)))
        return {false, 0, {Verdict::changed, "the file has changed at the server"}};
    const uint64_t expected = range.last - range.first + 1;
    if (length && *length != expected)
        return refused(core::text("server sent bytes %llu-%llu and a length of %llu", as_llu(range.first),
                                  as_llu(range.last), as_llu(*length)));
    return {true, expected, {}};
}

}  // namespace fetch
