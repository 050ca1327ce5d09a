#include "fetch/link_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

namespace {

using fetch::LinkEstimate;

constexpr uint64_t kHeader = 280;  // of an answer, as nginx sends it
constexpr uint64_t kFirst = 13 * 1024;

// A link that carries packets one after the other at a rate, and a client that keeps as much in flight as the
// estimate says.
class Carrier {
  public:
    Carrier(LinkEstimate& link, double bytes_per_s, double round_trip_s, double now = 0)
        : link_(link), bytes_per_s_(bytes_per_s), round_trip_s_(round_trip_s), now_(now) {}

    double now() const { return now_; }
    double seconds_at_the_rate() const { return double(sent_) / bytes_per_s_; }  // for all so far
    // The first request of all.
    void begin() {
        send(kFirst);
        while (!packets_.empty()) land();
    }
    // Returns when all has come.
    double carry(uint64_t total) {
        while (total > 0 || !packets_.empty()) {
            fill(total);
            land();
        }
        return now_;
    }
    // What is in flight stays so.
    void carry_some(uint64_t total) {
        while (total > 0) {
            fill(total);
            land();
        }
    }
    // Seconds until a block has come that is wanted from now on, and more than all else.
    double seconds_to_new_block() {
        const double start = now_;
        uint64_t others = 1 << 20;
        while (is_full()) land();
        const double arrival = send(1024);
        while (now_ < arrival) {
            fill(others);
            land();
        }
        return arrival - start;
    }

  private:
    struct Packet {
        double arrival;
        uint64_t bytes;
        double sent;  // the request that it is the header for; negative: none
    };
    bool is_full() const { return !packets_.empty() && link_.in_flight_bytes() >= link_.window_bytes(); }
    void fill(uint64_t& total) {
        while (total > 0 && !is_full()) {
            const uint64_t bytes =
                std::min(total, std::max<uint64_t>(1024, link_.request_bytes(6) / 1024 * 1024));
            send(bytes);
            total -= bytes;
        }
    }
    // Returns when all of it will have come.
    double send(uint64_t bytes) {
        link_.request_sent(now_, bytes);
        sent_ += kHeader + bytes;
        free_at_ = std::max(free_at_, now_ + round_trip_s_) + double(kHeader) / bytes_per_s_;
        packets_.push_back({free_at_, 0, now_});
        for (uint64_t at = 0; at < bytes; at += 1024) {
            const uint64_t size = std::min<uint64_t>(1024, bytes - at);
            free_at_ += double(size) / bytes_per_s_;
            packets_.push_back({free_at_, size, -1});
        }
        return free_at_;
    }
    void land() {
        const Packet landed = packets_.front();
        packets_.pop_front();
        now_ = landed.arrival;
        now_ = landed.arrival;
        if (landed.sent >= 0)
            link_.answer_began(now_, now_ - landed.sent, kHeader);
        else
            link_.bytes_came(now_, landed.bytes);
    }

    LinkEstimate& link_;
    double bytes_per_s_, round_trip_s_;
    double now_, free_at_ = 0;
    uint64_t sent_ = 0;  // with headers
    std::deque<Packet> packets_;
};

double carry(LinkEstimate& link, double bytes_per_s, double round_trip_s, uint64_t total, double now = 0) {
    return Carrier(link, bytes_per_s, round_trip_s, now).carry(total);
}

struct Link {
    double bytes_per_s, round_trip_s;
};
constexpr Link kLinks[] = {{384e3 / 8, 0.005}, {384e3 / 8, 0.04}, {384e3 / 8, 0.15},
                           {8e6 / 8, 0.005},   {8e6 / 8, 0.04},   {8e6 / 8, 0.15},
                           {100e6 / 8, 0.005}, {100e6 / 8, 0.04}, {100e6 / 8, 0.15}};

TEST(LinkEstimate, FillsEveryLinkAndHoldsLittleMoreInFlight) {
    for (const Link& is : kLinks) {
        LinkEstimate link;
        const uint64_t total = uint64_t(is.bytes_per_s * (4 + 20 * is.round_trip_s));
        Carrier carrier(link, is.bytes_per_s, is.round_trip_s);
        const double took = carrier.carry(total);
        const std::string name =
            testing::PrintToString(is.bytes_per_s) + " B/s, " + testing::PrintToString(is.round_trip_s);
        // Ten round trips of starting, as TCP would take too.
        EXPECT_LT(took, 1.1 * carrier.seconds_at_the_rate() + 12 * is.round_trip_s) << name;
        EXPECT_NEAR(link.bytes_per_s() / is.bytes_per_s, 1, 0.15) << name;
        EXPECT_NEAR(link.round_trip_s(), is.round_trip_s + kHeader / is.bytes_per_s, 0.1 * is.round_trip_s)
            << name;
        const double product = is.bytes_per_s * link.round_trip_s(), and_a_block = product + 1024 + kHeader;
        EXPECT_LE(double(link.window_bytes()),
                  std::max({1.8 * product, 1.2 * and_a_block, 0.0036 * is.bytes_per_s}))
            << name;
        EXPECT_GE(double(link.window_bytes()), std::max(1.2 * product, 0.9 * and_a_block)) << name;
        // A change of view waits for what is in flight: no longer than this beyond a round trip.
        EXPECT_LT(double(link.window_bytes() + link.request_bytes(6)) / is.bytes_per_s,
                  1.5 * is.round_trip_s + 0.13)
            << name;
    }
}

// A link that is always full shows no round trip, only the queue that the window makes.
TEST(LinkEstimate, DoesNotTakeItsOwnQueueForTheWay) {
    for (const Link& is : kLinks) {
        LinkEstimate link;
        const uint64_t total = uint64_t(is.bytes_per_s * 100);
        Carrier carrier(link, is.bytes_per_s, is.round_trip_s);
        const double took = carrier.carry(total);
        const std::string name =
            testing::PrintToString(is.bytes_per_s) + " B/s, " + testing::PrintToString(is.round_trip_s);
        const double product = is.bytes_per_s * is.round_trip_s + 1024 + 2 * kHeader;
        EXPECT_LE(double(link.window_bytes()), 1.8 * std::max(product, 0.002 * is.bytes_per_s)) << name;
        EXPECT_LT(took, 1.05 * carrier.seconds_at_the_rate() + 12 * is.round_trip_s)
            << name << ": looking for it costs little";
    }
}

// As TCP does: twice as much in each round trip, from 13 KiB on.
TEST(LinkEstimate, FillsALongFastLinkInFewRoundTrips) {
    LinkEstimate link;
    constexpr double kRate = 100e6 / 8, kRoundTrip = 0.15;
    EXPECT_LT(carry(link, kRate, kRoundTrip, 2'400'000), 2.4e6 / kRate + 11 * kRoundTrip);
}

// Each of them begins with ten segments; but a slow link is not filled with what they could bring.
TEST(LinkEstimate, BeginsAsTcpDoesOnAllItsConnections) {
    constexpr double kTcp = 6 * 14600 + kFirst;
    for (const Link& is : kLinks) {
        LinkEstimate link;
        Carrier carrier(link, is.bytes_per_s, is.round_trip_s);
        carrier.begin();
        link.set_connections(6);
        const double products = 2.5 * (is.bytes_per_s * is.round_trip_s + kHeader);
        EXPECT_NEAR(double(link.window_bytes()), std::min(kTcp, products), 0.02 * kTcp)
            << is.bytes_per_s << " B/s, " << is.round_trip_s << " s";
    }
    LinkEstimate link;
    constexpr double kRate = 100e6 / 8, kRoundTrip = 0.15;
    Carrier carrier(link, kRate, kRoundTrip);
    carrier.begin();
    link.set_connections(6);
    EXPECT_LT(carrier.carry(2'400'000), 2.4e6 / kRate + 7 * kRoundTrip);
}

// After a change of view: 1.5 round trips, and 100 ms for what is in flight and the block itself.
TEST(LinkEstimate, ANewBlockIsNotLateHoweverLongTheLinkWasFull) {
    for (const Link& is : kLinks) {
        LinkEstimate link;
        Carrier carrier(link, is.bytes_per_s, is.round_trip_s);
        double worst = 0;
        for (int i = 0; i != 40; ++i) {
            carrier.carry_some(uint64_t(is.bytes_per_s * 1.5));
            worst = std::max(worst, carrier.seconds_to_new_block());
        }
        EXPECT_LT(worst, 1.5 * is.round_trip_s + 0.1)
            << is.bytes_per_s << " B/s, " << is.round_trip_s << " s";
    }
}

// What nobody waits for fills the link, and nothing waits behind it.
TEST(LinkEstimate, HoldsOfIdleBytesOnlyWhatFillsTheLink) {
    for (const Link& is : kLinks) {
        LinkEstimate link;
        carry(link, is.bytes_per_s, is.round_trip_s, uint64_t(is.bytes_per_s * (4 + 20 * is.round_trip_s)));
        const double product = is.bytes_per_s * std::max(0.002, is.round_trip_s);
        EXPECT_LE(link.idle_window_bytes(), link.window_bytes());
        EXPECT_NEAR(double(link.idle_window_bytes()), product + 1024 + 2 * kHeader, 0.15 * product + kHeader)
            << is.bytes_per_s << " B/s, " << is.round_trip_s << " s";
    }
}

TEST(LinkEstimate, FollowsAWayThatBecomesLonger) {
    LinkEstimate link;
    const double now = carry(link, 1e6, 0.02, 2'000'000);
    carry(link, 1e6, 0.2, 30'000'000, now);
    EXPECT_NEAR(link.round_trip_s(), 0.2, 0.03);
}

TEST(LinkEstimate, FollowsALinkThatBecomesSlower) {
    LinkEstimate link;
    const double now = carry(link, 1e6, 0.04, 5'000'000);
    EXPECT_NEAR(link.bytes_per_s(), 1e6, 1e5);
    carry(link, 1e5, 0.04, 500'000, now);
    EXPECT_NEAR(link.bytes_per_s(), 1e5, 2e4);
}

TEST(LinkEstimate, PausesDoNotLowerTheRate) {
    LinkEstimate link;
    double now = 0;
    for (int i = 0; i != 50; ++i) now = 5 + carry(link, 1e6, 0.02, 100'000, now);
    EXPECT_GT(link.bytes_per_s(), 0.5e6);
}

// Few small requests at a time say nothing about a link, before it was full and afterwards.
TEST(LinkEstimate, ALinkThatWasNotFilledIsNotTakenForASlowOne) {
    constexpr double kRate = 1e6, kRoundTrip = 0.15;
    LinkEstimate link;
    const auto trickle = [&](double now) {
        for (int i = 0; i != 40; ++i) {
            link.request_sent(now, 2048);
            link.left_unfilled();
            link.answer_began(now + kRoundTrip, kRoundTrip, 0);
            link.bytes_came(now += kRoundTrip + 1024 / kRate, 1024);
            link.bytes_came(now += 1024 / kRate, 1024);
        }
        return now;
    };
    double now = trickle(0);
    EXPECT_GT(double(link.window_bytes()), 70'000) << "goes on as a start does, by what comes";
    now = carry(link, kRate, kRoundTrip, 4'000'000, now);
    EXPECT_NEAR(link.bytes_per_s(), kRate, 0.15 * kRate);
    trickle(now);
    EXPECT_NEAR(link.bytes_per_s(), kRate, 0.15 * kRate);
}

// But a slow one is filled by them.
TEST(LinkEstimate, FewSmallRequestsThatQueueShowASlowLink) {
    constexpr double kRate = 48e3, kRoundTrip = 0.04;
    constexpr uint64_t kBytes = 2048;
    LinkEstimate link;
    std::deque<double> sent;
    double now = 0, free_at = 0;
    for (int i = 0; i != 200; ++i) {
        while (sent.size() < 6) sent.push_back(now), link.request_sent(now, kBytes);
        link.left_unfilled();
        const double began = std::max(free_at, sent.front() + kRoundTrip);
        link.answer_began(std::max(now, began), std::max(now, began) - sent.front(), 0);
        now = free_at = began + kBytes / kRate;
        link.bytes_came(now, kBytes);
        sent.pop_front();
    }
    EXPECT_NEAR(link.bytes_per_s(), kRate, 0.15 * kRate);
    EXPECT_LT(link.share_bytes(6), kBytes);
}

TEST(LinkEstimate, WhatDoesNotComeIsNotInFlight) {
    LinkEstimate link;
    EXPECT_EQ(link.window_bytes(), 3072u) << "three blocks until anything is known";
    link.request_sent(0, 10'000);
    link.bytes_came(1, 4'000);
    EXPECT_EQ(link.in_flight_bytes(), 6'000u);
    link.request_ended(1, 6'000, true);
    EXPECT_EQ(link.in_flight_bytes(), 0u);
    link.bytes_came(2, 5);  // more than was asked for
    EXPECT_EQ(link.in_flight_bytes(), 0u);
}

}  // namespace
