// Pictures of what a point-sampling server, ppve-sample(1), has: a source that is asked while it is drawn.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ppve/client.h"

namespace qs_render {

struct Arguments;

// What --ppve can say: words with commas between, KEY or KEY=VALUE.
struct PointSettings {
    ppve::ClientOptions client;
    bool is_realtime = false;  // frames at the path's times, of what is there
    double scale = 1;
    struct Rule {
        double ratio, epsilon;
    };
    std::optional<Rule> rule;  // for coarse patches over fine ones; absent: as it suits the picture
    double velocity_px = 0;    // a frame, from which on a moving eye asks for less; 0: never
    uint64_t most_points = 4'000'000;
    bool is_closed = false;
    bool is_lit_by_server = false;
    std::string record;  // to this file; empty: not
};

// Throws core::UsageError for a word that is none.
PointSettings parse_point_settings(const std::string& words);

// Whether the command line names a server, a command that is one, or a recorded session.
bool draws_points(const Arguments& arguments);

// The whole of qs-render for these.  Throws core::UsageError for options that they have no use for.
void draw_points(const Arguments& arguments);

}  // namespace qs_render
