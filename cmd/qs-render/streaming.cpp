#include "qs-render/streaming.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "core/error.h"
#include "core/program.h"
#include "core/words.h"
#include "scene/remote_models.h"

namespace qs_render {

using core::text;
using core::UsageError;

namespace {

constexpr std::array<const char*, 6> kOrders = {"gain", "level", "radius", "screen", "y", "sweep"};
constexpr double kMostSeconds = 86400;

// A number at the beginning of `rest`, which is shortened by it.
bool take_number(std::string_view& rest, double& value) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return false;
    rest.remove_prefix(size_t(end - rest.data()));
    return true;
}

bool take_word(std::string_view& rest, std::string_view word) {
    if (!rest.starts_with(word)) return false;
    rest.remove_prefix(word.size());
    return true;
}

scene::Order order_of(const std::string& word) {
    return scene::Order(std::find(kOrders.begin(), kOrders.end(), word) - kOrders.begin());
}

scene::Magnifier magnifier_of(const std::string& word) {
    scene::Magnifier m;
    std::string_view rest = word;
    bool is_right = take_number(rest, m.at.x) && take_word(rest, ",") && take_number(rest, m.at.y) &&
                    take_word(rest, ",") && take_number(rest, m.radius_px);
    if (is_right && !rest.empty()) is_right = take_word(rest, ",") && take_number(rest, m.boost);
    if (!is_right || !rest.empty() || !(m.radius_px > 0) || !(m.boost > 0 && m.boost <= 1e6))
        throw UsageError("--magnify: '" + word +
                         "' is not X,Y,R or X,Y,R,BOOST with a radius above 0 and a boost above 0 up to 1e6");
    return m;
}

void check_modes(const StreamingOptions& o, bool has_path) {
    const std::pair<const char*, bool> modes[] = {{"--realtime", o.is_realtime()},
                                                  {"--settle", o.settle},
                                                  {"--snapshot", !o.snapshot.empty()},
                                                  {"--plan", o.plan}};
    const char* first = nullptr;
    for (const auto& [name, is_given] : modes) {
        if (is_given && first) throw UsageError(std::string(name) + ": not with " + first);
        if (is_given) first = name;
    }
    if (o.is_realtime() && !has_path)
        throw UsageError("--realtime: needs --path, along which the camera moves");
    if (!o.snapshot.empty() && has_path) throw UsageError("--snapshot: not with --path; it is of one camera");
    if (o.plan && o.has_budget())
        throw UsageError("--byte-budget: not with --plan, which has one of its own");
}

}  // namespace

bool StreamingOptions::has_budget() const {
    return byte_budget_option->count() > 0;
}

void StreamingOptions::add_to(core::Program& program) {
    CLI::App& app = program.options;
    all.push_back(app.add_option("--order", order, "Fetched first: gain, level, radius, screen, y or sweep")
                      ->check(core::one_of({kOrders.begin(), kOrders.end()}))
                      ->type_name("WORD"));
    all.push_back(program.add_number("--sweep-base", sweep_base, 1.001, 1000, "",
                                     "Sizes of a sweep, by the next one's (default sqrt 2)"));
    all.push_back(app.add_option("--magnify", magnify, "Pixels within R of X,Y count for BOOST (8)")
                      ->type_name("X,Y,R[,BOOST]"));
    all.push_back(
        app.add_flag("--no-prefetch", no_prefetch, "Fetch only what is seen, nothing ahead of the camera"));
    all.push_back(program.add_number("--realtime", realtime_fps, 0.001, 1000, "frames a second",
                                     "Move along the path so fast, whatever has arrived"));
    all.push_back(
        app.add_flag("--settle", settle, "Wait until all is there that a frame shows (the default)"));
    all.push_back(
        app.add_option("--snapshot", snapshot, "One camera, at these times after the start: 0s,1s,10s")
            ->type_name("TIMES"));
    byte_budget_option = program.add_size("--byte-budget", byte_budget, "Fetch no more than so much");
    byte_budget_option->default_str("");  // no limit
    all.push_back(byte_budget_option);
    all.push_back(app.add_flag("--plan", plan, "Say how many bytes the first frame needs; draw no picture"));
    all.push_back(app.add_option("--cache", cache, "Folder of qs-fetch's cache")->type_name("DIR"));
}

std::vector<double> snapshot_times_s(const std::string& word) {
    std::vector<double> times;
    std::string_view rest = word;
    while (!rest.empty()) {
        double time = 0;
        bool is_right = (times.empty() || take_word(rest, ",")) && take_number(rest, time);
        const double unit = take_word(rest, "ms")  ? 1e-3
                            : take_word(rest, "s") ? 1
                            : take_word(rest, "m") ? 60
                                                   : 0;
        time *= unit;
        is_right = is_right && unit > 0 && time >= 0 && time <= kMostSeconds &&
                   (times.empty() || time > times.back());
        if (!is_right)
            throw UsageError("--snapshot: '" + word +
                             "' is not a list of ascending times up to a day, like 0s,1s,10s,60s");
        times.push_back(time);
    }
    return times;
}

scene::StreamOptions stream_options(const StreamingOptions& o) {
    scene::StreamOptions options;
    options.order.order = order_of(o.order);
    if (!std::isnan(o.sweep_base)) options.order.sweep_base = o.sweep_base;
    if (!o.magnify.empty()) options.order.magnifier = magnifier_of(o.magnify);
    options.prefetches = !o.no_prefetch && !o.has_budget();
    if (o.has_budget()) options.byte_budget = o.byte_budget;
    return options;
}

Schedule::Schedule(const StreamingOptions& options, double begin_s)
    : begin_s_(begin_s), fps_(options.realtime_fps), snapshots_s_(snapshot_times_s(options.snapshot)) {}

std::optional<double> Schedule::due_s(size_t frame) const {
    if (!snapshots_s_.empty()) return snapshots_s_[frame];
    if (!std::isnan(fps_)) return begin_s_ + double(frame) / fps_;
    return std::nullopt;
}

void check(const StreamingOptions& o, const std::vector<scene::Source>& sources, bool has_path) {
    const bool is_remote = std::any_of(sources.begin(), sources.end(),
                                       [](const scene::Source& s) { return scene::is_url(s.file); });
    for (const CLI::Option* option : o.all)
        if (option->count() > 0 && !is_remote)
            throw UsageError(option->get_name() + ": needs a SOURCE of http:// or https://");
    stream_options(o);
    snapshot_times_s(o.snapshot);
    check_modes(o, has_path);
}

}  // namespace qs_render
