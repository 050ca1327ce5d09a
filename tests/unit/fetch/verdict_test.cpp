#include "fetch/verdict.h"

#include <gtest/gtest.h>

namespace {

using fetch::HttpFields;
using fetch::RangeRequest;
using Verdict = fetch::RangeEnd::Verdict;

HttpFields fields_of(std::initializer_list<const char*> lines) {
    HttpFields fields;
    for (const char* line : lines) fields.take_line(line, 0);
    return fields;
}

RangeRequest request_of(const char* etag, bool is_check) {
    return {"http://host/file", 0, 99, 1000, {etag, "Mon, 01 Jan 2024 00:00:00 GMT"}, true, is_check};
}

Verdict verdict_of(const RangeRequest& request, const HttpFields& fields,
                   std::optional<uint64_t> length = {}) {
    return judge(request, fields, length).end.verdict;
}

TEST(RangeRequest, IsConditionalOnTheBestValidatorThatMayBeUsed) {
    EXPECT_EQ(request_of("\"a\"", false).condition(), "If-Range: \"a\"");
    EXPECT_EQ(request_of("W/\"a\"", false).condition(), "If-Range: Mon, 01 Jan 2024 00:00:00 GMT");
    EXPECT_EQ(request_of("W/\"a\"", true).condition(), "If-None-Match: W/\"a\"");
    EXPECT_EQ(request_of("", true).condition(), "If-Modified-Since: Mon, 01 Jan 2024 00:00:00 GMT");
    RangeRequest first{"http://host/file", 0, 99, 0, {}, true, false};
    EXPECT_EQ(first.condition(), "");
    RangeRequest distrusted = request_of("\"a\"", false);
    distrusted.may_send_if_range = false;
    EXPECT_EQ(distrusted.condition(), "");
}

TEST(Verdict, TakesARangeOfTheSameVersionAndNoOther) {
    const auto request = request_of("\"a\"", false);
    const auto right =
        judge(request, fields_of({"HTTP/1.1 206 ", "ETag: \"a\"", "Content-Range: bytes 0-49/1000"}), 50);
    EXPECT_TRUE(right.is_accepted);
    EXPECT_EQ(right.expected, 50u) << "a server may send less";
    EXPECT_EQ(
        verdict_of(request, fields_of({"HTTP/1.1 206 ", "ETag: \"b\"", "Content-Range: bytes 0-99/1000"})),
        Verdict::changed);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 206 ", "Content-Range: bytes 0-99/1001"})),
              Verdict::changed);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 206 ", "Content-Range: bytes 0-100/1000"})),
              Verdict::refused);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 206 ", "Content-Range: bytes 0-99/1000"}), 101),
              Verdict::refused);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 200 ", "ETag: \"a\""}), 1000), Verdict::no_if_range);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 200 ", "ETag: \"b\""}), 1000), Verdict::changed);
    EXPECT_EQ(verdict_of(request, fields_of({"HTTP/1.1 304 "})), Verdict::refused) << "nobody asked";
}

TEST(Verdict, OfACheckIsOfTheVersionAlone) {
    const auto check = request_of("\"a\"", true);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 304 "})), Verdict::unchanged);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 200 ", "ETag: \"a\""}), 1000), Verdict::unchanged)
        << "a server that compares nothing, and knows no ranges any more";
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 200 "}), 999), Verdict::changed);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 206 ", "ETag: \"b\"", "Content-Range: bytes 0-0/1000"})),
              Verdict::changed);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 416 ", "Content-Range: bytes */0"})), Verdict::changed);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 404 "})), Verdict::refused);
    EXPECT_EQ(verdict_of(check, fields_of({"HTTP/1.1 503 "})), Verdict::retry);
}

TEST(Verdict, TellsWhatMayPassFromWhatMayNot) {
    const auto request = request_of("", false);
    for (const auto& [line, verdict] : {std::pair{"HTTP/1.1 500 ", Verdict::retry},
                                        {"HTTP/1.1 408 ", Verdict::retry},
                                        {"HTTP/1.1 425 ", Verdict::retry},
                                        {"HTTP/1.1 429 ", Verdict::busy},
                                        {"HTTP/1.1 403 ", Verdict::refused},
                                        {"HTTP/1.1 302 ", Verdict::refused},
                                        {"HTTP/1.1 204 ", Verdict::refused}})
        EXPECT_EQ(verdict_of(request, fields_of({line})), verdict) << line;
    const auto busy = judge(request, fields_of({"HTTP/1.1 503 ", "Retry-After: 7"}), {});
    EXPECT_EQ(busy.end.verdict, Verdict::busy);
    EXPECT_EQ(busy.end.retry_after_s, 7);
}

}  // namespace
