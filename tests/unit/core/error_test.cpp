#include "core/error.h"

#include <gtest/gtest.h>

namespace {

TEST(Text, FormatsLikePrintf) {
    EXPECT_EQ(core::text("%s: line %d: %.1f", "a.ply", 12, 1.5), "a.ply: line 12: 1.5");
}

TEST(Text, HasNoLimitOfLength) {
    const std::string longest(100000, 'x');
    EXPECT_EQ(core::text("<%s>", longest.c_str()), "<" + longest + ">");
    EXPECT_EQ(core::text("%s", ""), "");
}

}  // namespace
