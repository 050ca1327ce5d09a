#include "net/address.h"

#include <gtest/gtest.h>

namespace {

TEST(Address, IsWrittenAsItIsRead) {
    for (const char* text : {"127.0.0.1:4100", "localhost:0", "[::1]:65535", "/run/pm.socket", "./s"})
        EXPECT_EQ(net::to_text(net::parse_address(text)), text);
    EXPECT_EQ(net::to_text(net::parse_address(":4100")), "127.0.0.1:4100");
    EXPECT_EQ(net::to_text(net::parse_address("unix:socket")), "socket");
}

TEST(Address, RefusesWhatIsNone) {
    for (const std::string text :
         {"", "localhost", "localhost:", "localhost:65536", "a:-1", "::1:80", "a:1x", "unix:"})
        EXPECT_THROW(net::parse_address(text), core::UsageError) << text;
    EXPECT_THROW(net::parse_address("/" + std::string(200, 'a')), core::UsageError);
}

}  // namespace
