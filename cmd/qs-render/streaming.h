// How models from web servers are drawn while they arrive: the options, and the times of frames.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/program_fwd.h"
#include "scene/sources.h"
#include "scene/stream.h"

namespace qs_render {

struct StreamingOptions {
    std::string order = "gain", magnify, snapshot, cache;
    double sweep_base = NAN, realtime_fps = NAN;
    bool no_prefetch = false, settle = false, plan = false;
    uint64_t byte_budget = 0;
    CLI::Option* byte_budget_option = nullptr;
    std::vector<CLI::Option*> all{};

    void add_to(core::Program& program);
    bool is_realtime() const { return !std::isnan(realtime_fps); }
    bool has_budget() const;
    // Whether the times of frames are given, and not what is in them.
    bool draws_at_once() const { return is_realtime() || !snapshot.empty(); }
    // Whether frames wait until all is there that they show.
    bool settles() const { return !draws_at_once(); }
};

// These throw core::UsageError.
void check(const StreamingOptions& options, const std::vector<scene::Source>& sources, bool has_path);
scene::StreamOptions stream_options(const StreamingOptions& options);

// When frames are due, seconds from the start; the first one as soon as there is something to draw.
class Schedule {
  public:
    Schedule(const StreamingOptions& options, double begin_s);
    std::optional<double> due_s(size_t frame) const;  // nothing: at once

  private:
    double begin_s_, fps_;
    std::vector<double> snapshots_s_;
};
std::vector<double> snapshot_times_s(const std::string& word);  // ascending; empty where it is

}  // namespace qs_render
