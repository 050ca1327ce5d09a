#include "fetch/slow_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace {

using fetch::SlowLink;

constexpr double kRoundTrip = 0.04;
// Earlier than the link allows nothing may come; later, on a busy machine, by so much in the best of some
// runs.
constexpr double kLate = 0.5 * kRoundTrip;
constexpr int kRuns = 8;

// Seconds after which each of so many packets arrives, given to a link at once.
std::vector<double> arrivals_once(double bytes_per_s, int round_trips_to_connect, int packets) {
    net::EventLoop loop;
    SlowLink link(loop, bytes_per_s, kRoundTrip);
    std::vector<double> times;
    const double start = net::steady_seconds();
    link.connect(1, round_trips_to_connect);
    for (int i = 0; i != packets; ++i)
        link.pass(1, 1460, [&, packets] {
            times.push_back(net::steady_seconds() - start);
            if (int(times.size()) == packets) loop.stop();
        });
    loop.run();
    return times;
}

// The runs' earliest, until one is in time for `due_s`, the last packet's.
std::vector<double> arrivals(double bytes_per_s, int round_trips_to_connect, int packets, double due_s) {
    std::vector<double> best = arrivals_once(bytes_per_s, round_trips_to_connect, packets);
    for (int run = 1; run != kRuns && best.back() > due_s + kLate; ++run) {
        const std::vector<double> next = arrivals_once(bytes_per_s, round_trips_to_connect, packets);
        for (size_t i = 0; i != best.size(); ++i) best[i] = std::min(best[i], next[i]);
    }
    return best;
}

TEST(SlowLink, WithoutRateAndRoundTripPassesAtOnce) {
    net::EventLoop loop;
    SlowLink link(loop, 0, 0);
    bool has_come = false;
    link.pass(1, 1000, [&] { has_come = true; });
    EXPECT_TRUE(has_come);
}

TEST(SlowLink, ANewConnectionsFirstAnswerTakesTwoRoundTripsAndThreeWithTls) {
    for (const int to_connect : {0, 1, 2}) {
        const auto times = arrivals(0, to_connect, 10, (to_connect + 1) * kRoundTrip);
        for (const double time : times) {
            EXPECT_GE(time, (to_connect + 1) * kRoundTrip);
            EXPECT_LT(time, (to_connect + 1) * kRoundTrip + kLate);
        }
    }
}

TEST(SlowLink, AConnectionStartsWithTenPacketsARoundTripAndDoubles) {
    const auto times = arrivals(0, 1, 70, 4 * kRoundTrip);
    for (const int first_of_round : {0, 10, 30}) {
        const double round = 2 + (first_of_round > 0) + (first_of_round > 10);
        const int end = first_of_round == 0 ? 10 : first_of_round == 10 ? 30 : 70;
        for (int i = first_of_round; i != end; ++i) {
            EXPECT_GE(times[size_t(i)], round * kRoundTrip) << i;
            EXPECT_LT(times[size_t(i)], round * kRoundTrip + kLate) << i;
        }
    }
}

TEST(SlowLink, PacketsPassOneAfterTheOtherAtTheRate) {
    constexpr double kRate = 384e3 / 8;
    const auto times = arrivals(kRate, 1, 8, 2 * kRoundTrip + 8 * 1460 / kRate);
    for (size_t i = 0; i != times.size(); ++i)
        EXPECT_GE(times[i], 2 * kRoundTrip + double(i + 1) * 1460 / kRate) << i;
    EXPECT_LT(times.back(), 2 * kRoundTrip + 8 * 1460 / kRate + kLate);
}

TEST(SlowLink, AnOpenConnectionDoesNotWaitForOneThatIsBeingMade) {
    net::EventLoop loop;
    SlowLink link(loop, 1e6, kRoundTrip);
    std::vector<int> order;
    link.connect(1, 2);
    for (const int connection : {1, 2})
        link.pass(connection, 100, [&, connection] {
            order.push_back(connection);
            if (order.size() == 2) loop.stop();
        });
    loop.run();
    EXPECT_EQ(order, (std::vector{2, 1}));
}

}  // namespace
