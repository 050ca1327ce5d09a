#include "scene/stream.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace scene {

namespace {

// Of the requests of a server that are under way at a time a gap may take this part of one; see close_gaps().
constexpr double kGapParts = 24;
// Priorities of what nobody waits for (fetch/request_queue.h): the first of it, and what comes last of all.
constexpr float kIdle = 1e-24f, kLast = 1e-32f;
// As much is asked for that nobody waits for, in windows: what is under way, and what fills the link while a
// picture is drawn.
constexpr double kWindowsAsked = 2;
// A longer wait than this is cut into several, so that a stream that lost its daemon notices.
constexpr double kLongestWait_s = 1;
constexpr double kWidening = 1.25;       // of what is shown, to what is beside it
constexpr size_t kRestBlocks = 256;      // of the rest, to ask for at a time
constexpr double kPredictAhead_s = 0.2;  // beyond a round trip and a frame
// Two steps of a camera that differ by more than this part are no steady motion.
constexpr double kSteadiness = 0.5;
// With a budget blocks are asked for in batches, each of at most this part of what is left.
constexpr uint64_t kBudgetParts = 16;
constexpr size_t kMostOfBatch = 16;

bool is_same(const geom::View& a, const geom::View& b) {
    return a.width == b.width && a.height == b.height && a.focal_px == b.focal_px && a.eye == b.eye &&
           a.right == b.right && a.down == b.down && a.forward == b.forward;
}

bool are_same(std::span<const geom::View> a, std::span<const geom::View> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same);
}

geom::View widened(geom::View view) {
    const auto wider = [](int pixels) { return int(std::ceil(pixels * kWidening)); };
    view.width = wider(view.picture_width()), view.height = wider(view.picture_height());
    view.margins = {};
    return view;
}

// The view that is as far from `now` as `now` is from `before`, times `factor`.
geom::View extrapolated(const geom::View& before, const geom::View& now, double factor) {
    geom::View view = now;
    view.eye += factor * (now.eye - before.eye);
    const glm::dvec3 forward = now.forward + factor * (now.forward - before.forward);
    const glm::dvec3 right = now.right + factor * (now.right - before.right);
    const glm::dvec3 across = right - forward * (glm::dot(right, forward) / glm::dot(forward, forward));
    const double ahead = glm::length(forward), aside = glm::length(across);
    if (!(ahead > 1e-3 && aside > 1e-3)) return now;  // half a turn in a step
    view.forward = forward / ahead, view.right = across / aside;
    view.down = glm::cross(view.forward, view.right);
    return view;
}

// How far two views are from each other, for steps to be compared: the way of the eye by the distance at
// which it changes the picture as much as the turn does is not known, so each is held by itself.
struct Step {
    glm::dvec3 way, turn;
};
Step step_between(const geom::View& a, const geom::View& b) {
    return {b.eye - a.eye, b.forward - a.forward};
}
bool is_steady(const Step& a, const Step& b) {
    const auto alike = [](const glm::dvec3& u, const glm::dvec3& v) {
        return glm::length(v - u) <= kSteadiness * std::max(glm::length(u), glm::length(v));
    };
    return alike(a.way, b.way) && alike(a.turn, b.turn);
}

// In the same order, the most urgent first, once nothing else is to be fetched.
std::vector<BlockRequest> deferred(std::vector<BlockRequest> requests) {
    const float first = requests.empty() ? 1 : requests.front().priority;
    for (BlockRequest& r : requests) r.priority = std::max(2 * kLast, kIdle * (r.priority / first));
    return requests;
}

}  // namespace

Stream::Stream(const std::vector<PlacedModel>& models, BlockFetcher& fetcher, const StreamOptions& options)
    : models_(models), fetcher_(fetcher), options_(options), finder_(models), rest_from_(models.size(), 0) {}

double Stream::elapsed_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - options_.start).count();
}

void Stream::take_stock() {
    for (const PlacedModel& placed : models_) placed.model->take_stock();
}

bool Stream::is_there(const Block& block) const {
    return models_[block.first].model->is_there(block.second);
}

void Stream::show(std::vector<geom::View> views, const DrawOptions& options, std::optional<double> time_s) {
    while (fetcher_.wait(0)) {
    }
    take_stock();
    draw_ = options;
    const bool is_new = !are_same(views, views_);
    views_ = std::move(views);
    if (is_new) note_new_view();
    wanted_ = views_;
    if (time_s && options_.prefetches) predict(*time_s);
}

void Stream::note_new_view() {
    report_.first_picture_s.reset(), report_.full_coverage_s.reset();
    report_.error_below_s.fill(std::nullopt);
}

// Where the camera goes on as it went, the views when what is asked for now can be there.
void Stream::predict(double time_s) {
    if (!past_.empty() && !(time_s > past_.back().time_s)) past_.clear();
    past_.push_back({time_s, views_});
    if (past_.size() > 3) past_.erase(past_.begin());
    if (past_.size() < 3 || past_[0].views.size() != views_.size() || past_[1].views.size() != views_.size())
        return;
    const double frame_s = past_[2].time_s - past_[1].time_s;
    const double ahead_s = fetcher_.counters().round_trip_s + frame_s + kPredictAhead_s;
    for (size_t i = 0; i < views_.size(); ++i) {
        const geom::View &a = past_[0].views[i], &b = past_[1].views[i], &c = past_[2].views[i];
        if (is_steady(step_between(a, b), step_between(b, c)))
            wanted_[i] = extrapolated(b, c, ahead_s / frame_s);
    }
}

std::vector<Lack> Stream::find_lacks(std::span<const geom::View> views) {
    std::vector<Lack> lacks;
    for (const geom::View& view : views) {
        const std::vector<Lack> of_view = finder_.find(view, draw_, options_.order.magnifier);
        lacks.insert(lacks.end(), of_view.begin(), of_view.end());
    }
    return lacks;
}

std::vector<BlockRequest> Stream::requests_of(std::span<const Lack> lacks) const {
    return requests_for(lacks, options_.order, views_[0].picture_height());
}

// All blocks are alike, so that they come in the order of the file.
std::vector<BlockRequest> Stream::requests_for_rest() {
    std::vector<BlockRequest> requests;
    for (size_t m = 0; m < models_.size(); ++m) {
        uint64_t& from = rest_from_[m];
        const uint64_t end = models_[m].model->blocks_present();
        while (from < end && is_there({m, from})) ++from;
        for (uint64_t b = from; b < end && requests.size() < kRestBlocks; ++b)
            if (!is_there({m, b})) requests.push_back({m, b, kLast});
    }
    return requests;
}

// Where nothing that is seen is lacking: what is beside it and what is hidden, the most urgent of both first,
// and then the rest.  (Without what is hidden a picture is not quite that of the whole model: what waits may
// reach out from behind.)
std::vector<BlockRequest> Stream::requests_when_idle() {
    if (!options_.prefetches) return {};
    std::vector<geom::View> wider;
    for (const geom::View& view : wanted_) wider.push_back(widened(view));
    std::vector<BlockRequest> requests;
    std::set<Block> asked;
    for (const auto& idle : {deferred(requests_of(find_lacks(wider))),
                             deferred(requests_for_hidden(find_lacks(views_))), requests_for_rest()})
        std::copy_if(idle.begin(), idle.end(), std::back_inserter(requests),
                     [&](const BlockRequest& r) { return asked.emplace(r.model, r.block).second; });
    return requests;
}

// Batches that are waited for, so that a budget brings the same blocks whatever the link.
std::vector<BlockRequest> Stream::within_budget(std::vector<BlockRequest> requests) {
    const uint64_t used = fetcher_.counters().bytes;
    const uint64_t left = *options_.byte_budget - std::min(*options_.byte_budget, used);
    size_t count = 0;
    uint64_t sum = 0;
    while (count < std::min(requests.size(), kMostOfBatch)) {
        sum += fetcher_.most_bytes(requests[count]);
        if (sum > (count == 0 ? left : left / kBudgetParts)) break;
        ++count;
    }
    report_.is_budget_used = count == 0 && !requests.empty();
    requests.resize(count);
    return requests;
}

// A gap costs what it takes to bring it; a request more, a round trip on one of a few connections.  (With
// HTTP/2, and where links are slow or short, products are small and so are the gaps.)
void Stream::close_gaps(std::vector<BlockRequest>& requests) const {
    const BlockFetcher::Counters link = fetcher_.counters();
    const double product = link.bytes_per_s * link.round_trip_s;
    std::vector<Block> asked;
    for (const BlockRequest& r : requests) asked.emplace_back(r.model, r.block);
    std::sort(asked.begin(), asked.end());
    for (size_t i = 1; i < asked.size(); ++i) {
        const auto& [model, end] = asked[i];
        const uint64_t begin = asked[i - 1].second + 1;
        const double widest = product / kGapParts / double(models_[model].model->mean_block_bytes());
        if (asked[i - 1].first != model || begin >= end || double(end - begin) > widest) continue;
        for (uint64_t b = begin; b < end; ++b)
            if (!is_there({model, b})) requests.push_back({model, b, kLast});
    }
}

// What is below a block is known once it is there, and until then a long link would stand idle: what it
// carries meanwhile is what the picture hides, and the file from its beginning on, which is coarse to fine.
void Stream::fill_link(std::vector<BlockRequest>& requests, std::span<const Lack> lacks) {
    const double most = kWindowsAsked * double(fetcher_.counters().window_bytes);
    std::set<Block> asked;
    double bytes = 0;
    const auto is_new = [&](const BlockRequest& r) {
        if (!asked.emplace(r.model, r.block).second) return false;
        bytes += double(models_[r.model].model->mean_block_bytes());
        return true;
    };
    for (const BlockRequest& r : requests) is_new(r);
    for (const auto& idle : {deferred(requests_for_hidden(lacks)), requests_for_rest()})
        for (const BlockRequest& r : idle) {
            if (bytes >= most) return;
            if (is_new(r)) requests.push_back(r);
        }
}

void Stream::ask(std::vector<BlockRequest> requests) {
    if (options_.byte_budget) {
        std::erase_if(pending_, [&](const BlockRequest& r) { return is_there({r.model, r.block}); });
        if (pending_.empty()) pending_ = within_budget(std::move(requests));
        requests = pending_;
    } else if (options_.prefetches) {
        close_gaps(requests);
    }
    for (const BlockRequest& r : requests) asked_.insert({r.model, r.block});
    fetcher_.ask(requests);
}

// While pictures go on.  (Who waits for all of a view is not helped by other blocks.)
void Stream::ask_in_time(std::vector<BlockRequest> requests, std::span<const Lack> lacks) {
    if (!requests.empty() && options_.prefetches && !options_.byte_budget) fill_link(requests, lacks);
    ask(std::move(requests));
}

// Of what hides nothing that is lacking, no bit depends on what is lacking.
bool Stream::is_exact(ModelPainter& painter) {
    DrawOptions options = draw_;
    if (painter.can_hide() && options.look.samples_across == 1) options.occlusion = Occlusion::on;
    render::Frame frame;
    return std::all_of(views_.begin(), views_.end(), [&](const geom::View& view) {
        return painter.draw(view, options, frame).counts.groups_missing == 0;
    });
}

void Stream::settle(ModelPainter& painter) {
    for (;;) {
        const std::vector<Lack> lacks = find_lacks(views_);
        if (lacks.empty()) return;
        std::vector<BlockRequest> requests = requests_of(lacks);
        if (requests.empty()) {
            if (is_exact(painter)) return;
            requests = requests_for_hidden(lacks);
        }
        ask(std::move(requests));
        if (report_.is_budget_used) return;
        while (!fetcher_.wait(kLongestWait_s) && !fetcher_.has_ended()) {
        }
        if (fetcher_.has_ended()) return;
        take_stock();
    }
}

void Stream::ask_ahead() {
    take_stock();
    if (views_.empty()) return;
    std::vector<Lack> lacks = find_lacks(wanted_);
    std::vector<BlockRequest> requests = requests_of(lacks);
    if (requests.empty() && !are_same(wanted_, views_)) {
        lacks = find_lacks(views_);
        requests = requests_of(lacks);
    }
    if (requests.empty())
        ask(requests_when_idle());
    else
        ask_in_time(std::move(requests), lacks);
}

void Stream::wait_until(double until_s) {
    bool has_come = true;  // what look() asked for was less than all
    for (double left; (left = until_s - elapsed_s()) > 0;) {
        if (has_come) {
            ask_ahead();
            left = std::max(0.0, until_s - elapsed_s());
        }
        has_come = fetcher_.wait(std::min(left, kLongestWait_s));
    }
}

StreamReport Stream::look(const ModelPainter& painter, const DrawReport& drawn) {
    const std::vector<Lack> lacks =
        drawn.counts.groups_missing == 0 ? std::vector<Lack>() : find_lacks(views_);
    measure(lacks, painter, drawn);
    if (lacks.empty()) return report_;
    const std::vector<Lack> ahead = are_same(wanted_, views_) ? lacks : find_lacks(wanted_);
    ask_in_time(requests_of(ahead), ahead);
    return report_;
}

void Stream::measure(std::span<const Lack> lacks, const ModelPainter& painter, const DrawReport& drawn) {
    report_.elapsed_s = elapsed_s();
    report_.network = fetcher_.counters();
    std::map<Block, std::pair<uint32_t, bool>>
        missing;  // its nodes' least level, and whether some own pixels
    report_.waiting_error_px = 0;
    for (const Lack& lack : lacks) {
        auto& [level, is_visible] =
            missing.try_emplace({lack.model, lack.node.block}, lack.node.level, false).first->second;
        level = std::min(level, lack.node.level);
        is_visible = is_visible || lack.pixels > 0;
        if (lack.pixels > 0)
            report_.waiting_error_px = std::max(report_.waiting_error_px, double(lack.node.error_px));
    }
    report_.blocks_missing.clear();
    report_.visible_blocks_missing = 0;
    for (const auto& [block, of] : missing) {
        report_.blocks_missing.resize(std::max<size_t>(report_.blocks_missing.size(), of.first + 1));
        ++report_.blocks_missing[of.first];
        report_.visible_blocks_missing += of.second;
    }
    const double there = double(drawn.counts.blocks_touched);
    report_.hit_rate = there / std::max(1.0, there + double(missing.size()));
    report_.visible_hit_rate = there / std::max(1.0, there + double(report_.visible_blocks_missing));
    uint64_t used_bytes = 0;
    report_.wasted_bytes = 0;
    for (const Block& block : asked_)
        if (is_there(block) && !painter.has_used(block.first, block.second))
            report_.wasted_bytes += models_[block.first].model->mean_block_bytes();
    for (const PlacedModel& placed : models_)
        used_bytes += placed.model->blocks_used() * placed.model->mean_block_bytes();
    report_.cache_hit_rate =
        1 - std::min(1.0, double(report_.network.bytes) / std::max(1.0, double(used_bytes)));
    const auto note = [&](std::optional<double>& time_s, bool is_reached) {
        if (is_reached && !time_s) time_s = report_.elapsed_s;
    };
    note(report_.first_picture_s, true);
    note(report_.full_coverage_s, report_.visible_blocks_missing == 0);
    for (size_t i = 0; i < kErrorSteps_px.size(); ++i)
        note(report_.error_below_s[i], report_.waiting_error_px < kErrorSteps_px[i]);
}

}  // namespace scene
