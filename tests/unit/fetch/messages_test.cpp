#include "fetch/messages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace {

using fetch::Reply;
using fetch::ReplyKind;
using fetch::Request;
using fetch::RequestKind;

TEST(Messages, RequestsReadBack) {
    Request open;
    open.kind = RequestKind::open;
    open.stream = 7;
    open.url = "http://example.org/";
    EXPECT_EQ(fetch::parse_request(to_bytes(open)).url, open.url);
    EXPECT_EQ(fetch::parse_request(to_bytes(open)).stream, 7u);
    Request want;
    want.kind = RequestKind::want;
    want.stream = 3;
    want.wants = {{1, 0.5f}, {UINT32_MAX, 1e30f}};
    const Request read = fetch::parse_request(to_bytes(want));
    ASSERT_EQ(read.wants.size(), 2u);
    EXPECT_EQ(read.wants[1].block, UINT32_MAX);
    EXPECT_EQ(read.wants[1].priority, 1e30f);
    Request evict;
    evict.kind = RequestKind::evict;
    evict.keep_bytes = 1ull << 40;
    EXPECT_EQ(fetch::parse_request(to_bytes(evict)).keep_bytes, 1ull << 40);
}

TEST(Messages, RepliesReadBackAndAreCutToTheLimit) {
    Reply opened;
    opened.kind = ReplyKind::opened;
    opened.stream = 9;
    opened.file_bytes = 1ull << 39;
    opened.block_bytes = 1024;
    EXPECT_EQ(fetch::parse_reply(to_bytes(opened)).file_bytes, 1ull << 39);
    Reply ended;
    ended.kind = ReplyKind::ended;
    ended.reason = fetch::Reason::replaced;
    ended.text = std::string(100'000, 'x');
    EXPECT_LE(to_bytes(ended).size(), fetch::kMostMessageBytes);
    EXPECT_EQ(fetch::parse_reply(to_bytes(ended)).reason, fetch::Reason::replaced);
}

TEST(Messages, AFullListOfWantsFits) {
    Request want;
    want.kind = RequestKind::want;
    want.wants.assign(fetch::kMostWants, {1, 1});
    EXPECT_LE(to_bytes(want).size(), fetch::kMostMessageBytes);
    EXPECT_EQ(fetch::parse_request(to_bytes(want)).wants.size(), fetch::kMostWants);
    want.wants.push_back({1, 1});
    EXPECT_THROW(fetch::parse_request(to_bytes(want)), core::Error);
}

TEST(Messages, RefuseWhatIsCutOffOrLongerOrNoNumber) {
    Request want;
    want.kind = RequestKind::want;
    want.wants = {{1, 1}};
    auto bytes = to_bytes(want);
    for (size_t size = 0; size != bytes.size(); ++size) {
        if (size == 8) continue;  // a want of nothing
        EXPECT_THROW(fetch::parse_request(std::span(bytes).first(size)), core::Error) << size;
    }
    for (const float priority : {-1.0f, std::nanf(""), INFINITY}) {
        want.wants = {{1, priority}};
        EXPECT_THROW(fetch::parse_request(to_bytes(want)), core::Error) << priority;
    }
    Request status;
    bytes = to_bytes(status);
    bytes.push_back({});
    EXPECT_THROW(fetch::parse_request(bytes), core::Error);
}

}  // namespace
