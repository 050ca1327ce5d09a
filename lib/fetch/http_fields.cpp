#include "fetch/http_fields.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>

namespace fetch {

namespace {

constexpr size_t kMostValidatorBytes = 1024, kMostDateBytes = 64;

std::string_view trimmed(std::string_view text) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = char(c + ('a' - 'A'));
    return out;
}

// Takes digits, which must fit, off the front.
std::optional<uint64_t> take_number(std::string_view& text) {
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return {};
    text.remove_prefix(size_t(end - text.data()));
    return value;
}

bool take(std::string_view& text, std::string_view what) {
    if (!text.starts_with(what)) return false;
    text.remove_prefix(what.size());
    return true;
}

// A name to hold against another answer's, and to send back: no longer than any server makes it.
std::string validator_of(std::string_view value) {
    const bool is_plain =
        std::all_of(value.begin(), value.end(), [](char c) { return c >= ' ' && c <= '~'; });
    return value.size() <= kMostValidatorBytes && is_plain ? std::string(value) : std::string();
}

}  // namespace

std::optional<ContentRange> parse_content_range(std::string_view value) {
    std::string_view text = trimmed(value);
    if (text.size() < 6 || lower(text.substr(0, 6)) != "bytes ") return {};
    text = trimmed(text.substr(6));
    ContentRange range;
    if (!take(text, "*")) {
        const std::optional<uint64_t> first = take_number(text);
        if (!first || !take(text, "-")) return {};
        const std::optional<uint64_t> last = take_number(text);
        if (!last || *last < *first) return {};
        range = {true, *first, *last, 0};
    }
    if (!take(text, "/")) return {};
    const std::optional<uint64_t> total = take_number(text);
    if (!total || !text.empty() || (range.has_bytes && range.last >= *total)) return {};
    range.total = *total;
    return range;
}

std::optional<int64_t> parse_retry_after(std::string_view value, int64_t now_s) {
    std::string_view text = trimmed(value);
    if (const std::optional<uint64_t> seconds = take_number(text); seconds && text.empty())
        return int64_t(std::min<uint64_t>(*seconds, kMostRetrySeconds));
    const std::string date(trimmed(value));
    if (date.size() > kMostDateBytes) return {};
    const time_t then = curl_getdate(date.c_str(), nullptr);
    if (then == -1) return {};
    return std::clamp<int64_t>(int64_t(then) - now_s, 0, kMostRetrySeconds);
}

void HttpFields::take_line(std::string_view line, int64_t now_s) {
    if (line.starts_with("HTTP/")) {
        *this = HttpFields();
        const size_t blank = line.find(' ');
        std::string_view rest = blank == std::string_view::npos ? "" : line.substr(blank + 1);
        status = int(std::min<uint64_t>(take_number(rest).value_or(0), 999));
        return;
    }
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos) return;
    const std::string name = lower(trimmed(line.substr(0, colon)));
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (name == "content-range") {
        // Two of them leave open which bytes are meant.
        has_bad_content_range |= content_range.has_value();
        content_range = parse_content_range(value);
        has_bad_content_range |= !content_range;
    } else if (name == "content-type") {
        is_multipart = lower(value).starts_with("multipart/");
    } else if (name == "content-encoding") {
        content_encoding = lower(value) == "identity" ? "" : lower(value.substr(0, 64));
    } else if (name == "etag") {
        validator.etag = validator_of(value);
    } else if (name == "last-modified") {
        validator.last_modified = validator_of(value);
    } else if (name == "retry-after") {
        retry_after = value.substr(0, kMostDateBytes + 1);
        retry_after_s = parse_retry_after(retry_after, date_s.value_or(now_s));
    } else if (name == "date" && value.size() <= kMostDateBytes) {
        const time_t date = curl_getdate(std::string(value).c_str(), nullptr);
        if (date == -1) return;
        date_s = date;
        retry_after_s = parse_retry_after(retry_after, date);
    }
}

std::string strong_validator(const Validator& validator) {
    if (!validator.etag.empty() && !validator.etag.starts_with("W/")) return validator.etag;
    return validator.last_modified;
}

}  // namespace fetch
