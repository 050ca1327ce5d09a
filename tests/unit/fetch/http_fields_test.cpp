#include "fetch/http_fields.h"

#include <gtest/gtest.h>

namespace {

using fetch::parse_content_range;
using fetch::parse_retry_after;

TEST(ContentRange, IsReadAsServersWriteIt) {
    const auto range = parse_content_range(" bytes 0-1023/4096 ");
    ASSERT_TRUE(range);
    EXPECT_TRUE(range->has_bytes);
    EXPECT_EQ(range->first, 0u);
    EXPECT_EQ(range->last, 1023u);
    EXPECT_EQ(range->total, 4096u);
    EXPECT_EQ(parse_content_range("Bytes 5-5/6")->last, 5u);
    const auto refused = parse_content_range("bytes */4096");
    ASSERT_TRUE(refused);
    EXPECT_FALSE(refused->has_bytes);
    EXPECT_EQ(refused->total, 4096u);
}

TEST(ContentRange, RefusesWhatDoesNotSayWhichBytesOfHowMany) {
    for (const char* text :
         {"", "bytes", "bytes ", "bytes 0-1", "bytes 0-1/", "bytes 0-1/*", "bytes -1/5", "bytes 3-2/5",
          "bytes 0-5/5", "bytes 0-1/5x", "bytes 0-1/18446744073709551616", "bytes 0-1/-5", "bytes=0-1/5",
          "lines 0-1/5", "bytes 0 - 1/5", "bytes */*", "bytes +0-1/5"})
        EXPECT_FALSE(parse_content_range(text)) << text;
}

TEST(RetryAfter, IsSecondsOrADateAndNeverMoreThanALimit) {
    EXPECT_EQ(parse_retry_after("120", 0), 120);
    EXPECT_EQ(parse_retry_after("0", 0), 0);
    EXPECT_EQ(parse_retry_after("999999999999", 0), fetch::kMostRetrySeconds);
    EXPECT_EQ(parse_retry_after("Mon, 01 Jan 2024 00:00:10 GMT", 1704067200), 10);
    EXPECT_EQ(parse_retry_after("Mon, 01 Jan 2024 00:00:10 GMT", 1704067300), 0) << "it has passed";
    EXPECT_EQ(parse_retry_after("Mon, 01 Jan 2024 00:00:10 GMT", 0), fetch::kMostRetrySeconds);
    EXPECT_FALSE(parse_retry_after("soon", 0));
    EXPECT_FALSE(parse_retry_after("-5", 0));
    EXPECT_FALSE(parse_retry_after("", 0));
}

fetch::HttpFields fields_of(const std::vector<std::string>& lines) {
    fetch::HttpFields fields;
    for (const std::string& line : lines) fields.take_line(line + "\r\n", 0);
    return fields;
}

TEST(HttpFields, BelongToTheLastAnswerOfARedirect) {
    const auto fields =
        fields_of({"HTTP/1.1 302 Found", "ETag: \"of the redirect\"", "Content-Encoding: gzip", "",
                   "HTTP/2 206", "content-range: bytes 0-1/2", "eTAG:\"x\"", ""});
    EXPECT_EQ(fields.status, 206);
    EXPECT_EQ(fields.validator.etag, "\"x\"");
    EXPECT_EQ(fields.content_encoding, "");
    EXPECT_TRUE(fields.content_range);
}

TEST(HttpFields, ADateToWaitForIsHeldAgainstTheServersClock) {
    const char* const date = "Date: Mon, 01 Jan 2024 00:00:00 GMT";
    const char* const until = "Retry-After: Mon, 01 Jan 2024 00:00:07 GMT";
    for (const bool is_date_first : {true, false}) {
        fetch::HttpFields fields;
        for (const char* line : {"HTTP/1.1 429 ", is_date_first ? date : until, is_date_first ? until : date})
            fields.take_line(line, 0);
        EXPECT_EQ(fields.retry_after_s, 7);
    }
    fetch::HttpFields fields;
    for (const char* line : {"HTTP/1.1 200 ", date}) fields.take_line(line, 0);
    EXPECT_FALSE(fields.retry_after_s);
}

TEST(HttpFields, TellOfAContradiction) {
    EXPECT_TRUE(fields_of({"HTTP/1.1 206", "Content-Range: bytes 0-1/2", "Content-Range: bytes 0-1/3"})
                    .has_bad_content_range);
    EXPECT_TRUE(fields_of({"HTTP/1.1 206", "Content-Range: nonsense"}).has_bad_content_range);
    EXPECT_TRUE(fields_of({"HTTP/1.1 206", "Content-Type: Multipart/byteranges"}).is_multipart);
    EXPECT_EQ(fields_of({"HTTP/1.1 206", "Content-Encoding: GZip"}).content_encoding, "gzip");
    EXPECT_EQ(fields_of({"HTTP/1.1 206", "Content-Encoding: identity"}).content_encoding, "");
}

TEST(HttpFields, KeepNoValidatorThatCannotBeSentBack) {
    EXPECT_EQ(fields_of({"HTTP/1.1 206", "ETag: \"a\x01\""}).validator.etag, "");
    EXPECT_EQ(fields_of({"HTTP/1.1 206", "ETag: " + std::string(5000, 'x')}).validator.etag, "");
    EXPECT_EQ(fields_of({"HTTP/1.1 xyz", "no colon"}).status, 0);
}

TEST(HttpFields, AWeakTagIsNoneForIfRange) {
    EXPECT_EQ(fetch::strong_validator({"\"a\"", "today"}), "\"a\"");
    EXPECT_EQ(fetch::strong_validator({"W/\"a\"", "today"}), "today");
    EXPECT_EQ(fetch::strong_validator({"W/\"a\"", ""}), "");
}

}  // namespace
