#include "fetch/request_queue.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace {

using fetch::RequestQueue;
using fetch::Want;

std::string taken(RequestQueue& queue, uint32_t most, float alike) {
    std::string text;
    while (!queue.is_empty()) {
        const auto range = queue.take({most, alike});
        text += std::to_string(range.first) + "+" + std::to_string(range.count) + " ";
    }
    return text;
}

TEST(RequestQueue, GivesTheMostUrgentFirstAndTheFirstInTheFileOfEquals) {
    RequestQueue queue;
    queue.replace({{30, 1}, {10, 5}, {20, 3}, {40, 3}});
    EXPECT_EQ(queue.head_priority(), 5);
    EXPECT_EQ(taken(queue, 16, 0.3f), "10+1 20+1 40+1 30+1 ");
    EXPECT_EQ(queue.head_priority(), 0);
}

TEST(RequestQueue, JoinsNeighboursOfLikePriorityAlone) {
    RequestQueue queue;
    queue.replace({{9, 4}, {10, 10}, {11, 3}, {12, 2.9f}, {14, 9}});
    EXPECT_EQ(taken(queue, 16, 0.3f), "9+3 14+1 12+1 ");
    queue.replace({{9, 4}, {10, 10}, {11, 3}, {12, 2.9f}});
    EXPECT_EQ(taken(queue, 2, 0.3f), "10+2 9+1 12+1 ");
    queue.replace({{1, 0}, {2, 0}});
    EXPECT_EQ(taken(queue, 16, 0.3f), "1+2 ");
}

TEST(RequestQueue, TakesAnyNeighboursForARangeThatMustBeLonger) {
    RequestQueue queue;
    queue.replace({{9, 4}, {10, 10}, {11, 1}, {12, 1}, {14, 9}});
    const auto range = queue.take({16, 0.3f, 3});
    EXPECT_EQ(range.first, 9u) << "the alike first, then others";
    EXPECT_EQ(range.count, 3u);
    EXPECT_EQ(taken(queue, 16, 0.3f), "14+1 12+1 ");
    queue.replace({{9, 4}, {10, 10}, {11, 1}});
    EXPECT_EQ(queue.take({2, 0.3f, 5}).count, 2u) << "never more than may be";
}

TEST(RequestQueue, CountsABlockOnceWithItsHighestPriority) {
    RequestQueue queue;
    queue.replace({{7, 1}, {8, 2}, {7, 9}, {7, 3}});
    EXPECT_EQ(queue.head_priority(), 9);
    EXPECT_EQ(taken(queue, 1, 1), "7+1 8+1 ");
}

TEST(RequestQueue, AnEndOfTheNumbersIsNoNeighbourOfTheStart) {
    RequestQueue queue;
    queue.replace({{0, 1}, {UINT32_MAX, 1}});
    EXPECT_EQ(taken(queue, 16, 0), "0+1 4294967295+1 ");
}

TEST(RequestQueue, GivesEveryBlockOnceWhateverTheOrder) {
    std::mt19937 random(3);
    for (int run = 0; run != 200; ++run) {
        std::vector<Want> wants;
        std::map<uint32_t, int> left;
        for (int i = 0; i != 100; ++i) {
            wants.push_back({uint32_t(random()) % 150, float(random() % 8)});
            left[wants.back().block] = 1;
        }
        RequestQueue queue;
        queue.replace(wants);
        const uint32_t most = 1 + uint32_t(random()) % 20, least = 1 + uint32_t(random()) % 5;
        while (!queue.is_empty()) {
            const auto range = queue.take({most, 0.3f, least});
            EXPECT_LE(range.count, most);
            for (uint32_t block = range.first; block != range.first + range.count; ++block)
                EXPECT_EQ(left[block]--, 1);
        }
        for (const auto& [block, count] : left) EXPECT_EQ(count, 0) << block;
    }
}

}  // namespace
