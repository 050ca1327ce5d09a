// Drawing models while they arrive: asks for what a picture lacks, waits for it where that is wanted, and
// measures what has come of it.
//
//     stream.show(views, options);         // what will be drawn, of what has arrived by now
//     stream.settle(painter);              // or not: pictures never wait
//     drawn = painter.draw(...);
//     report = stream.look(painter, drawn);  // asks for what it lacks
//     stream.wait_until(0.5);              // goes on asking as blocks arrive
//
// Asked for is, each only once nothing of the one before is missing:
//     what the views show, in the order of the options; where the camera moves, what it will see by the time
//     that
//         the blocks are there instead of what it sees now (a steady pan then lacks 0.2 % of what it needs
//         instead of 4 % in simulation; asking for both, or less urgently, gains less)
//     what they hide, where settle() is to be exact
//     in idle time, what is beside them, what they hide, and then the rest from root to leaves.
// What of these a link carries that would stand idle comes before its turn, so much that nothing waits for
// it; and between blocks that are asked for, those that are not are asked for too, last of all, where that
// makes requests of a length that fills a long link: over HTTP/1.1 few requests are under way at a time.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "scene/block_fetcher.h"
#include "scene/draw.h"
#include "scene/lacks.h"
#include "scene/request_order.h"

namespace scene {

struct StreamOptions {
    OrderOptions order;
    bool prefetches = true;
    std::optional<uint64_t> byte_budget{};  // of the network; nothing is asked for beyond it
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();  // of elapsed_s
};

// Errors that pictures fall below; see error_below_s.
inline constexpr std::array<double, 4> kErrorSteps_px = {8, 4, 2, 1};

struct StreamReport {
    double elapsed_s = 0;  // since the start
    BlockFetcher::Counters network;
    // Of the last picture: blocks that nodes in it wait for, by the level of these nodes; of these blocks the
    // ones whose nodes own pixels; the largest projected error of what owns pixels and waits.
    std::vector<uint64_t> blocks_missing;
    uint64_t visible_blocks_missing = 0;
    double waiting_error_px = 0;
    // Of what the last picture's cut needs, as far as that is known, the part that is there; and where only
    // what owns pixels is taken to be lacking.
    double hit_rate = 1, visible_hit_rate = 1;
    // Of the bytes used so far, the part that did not come over the network.
    double cache_hit_rate = 0;
    uint64_t wasted_bytes = 0;    // asked for and there, but never used for a picture
    bool is_budget_used = false;  // so that more is lacking than will be asked for
    // When pictures of the view (since it last changed) first were there, lacked nothing that is visible, and
    // were better than kErrorSteps_px; by elapsed_s.
    std::optional<double> first_picture_s, full_coverage_s;
    std::array<std::optional<double>, kErrorSteps_px.size()> error_below_s{};
};

class Stream {
  public:
    // What is given lives longer.  Models that do not arrive lack nothing.
    Stream(const std::vector<PlacedModel>& models, BlockFetcher& fetcher, const StreamOptions& options);

    // Begins with pictures: of what has arrived by now.  `time_s`: where they are of a path on which the
    // camera moves.  The views are those of one moment, two eyes' perhaps.
    void show(std::vector<geom::View> views, const DrawOptions& options,
              std::optional<double> time_s = std::nullopt);

    // Waits until all is there that the views show, so that their pictures are those of the whole models, or
    // the budget is used up.  Draws with `painter` to find out what is hidden.
    void settle(ModelPainter& painter);

    // After the pictures were drawn: `drawn` is what they have together.
    StreamReport look(const ModelPainter& painter, const DrawReport& drawn);

    // Asks for what may be wanted once nothing that is seen is missing; what comes of it the fetcher says.
    void ask_ahead();
    // The same again and again, until this time has passed since the start.
    void wait_until(double elapsed_s);
    double elapsed_s() const;

  private:
    using Block = std::pair<size_t, uint64_t>;  // model, number

    std::vector<Lack> find_lacks(std::span<const geom::View> views);
    std::vector<BlockRequest> requests_of(std::span<const Lack> lacks) const;
    std::vector<BlockRequest> requests_for_rest();
    std::vector<BlockRequest> requests_when_idle();
    void close_gaps(std::vector<BlockRequest>& requests) const;
    void fill_link(std::vector<BlockRequest>& requests, std::span<const Lack> lacks);
    bool is_exact(ModelPainter& painter);
    void predict(double time_s);
    bool is_there(const Block& block) const;
    std::vector<BlockRequest> within_budget(std::vector<BlockRequest> requests);
    void ask(std::vector<BlockRequest> requests);
    void ask_in_time(std::vector<BlockRequest> requests, std::span<const Lack> lacks);
    void take_stock();
    void note_new_view();
    void measure(std::span<const Lack> lacks, const ModelPainter& painter, const DrawReport& drawn);

    std::vector<PlacedModel> models_;
    BlockFetcher& fetcher_;
    const StreamOptions options_;
    LackFinder finder_;
    DrawOptions draw_;
    std::vector<geom::View> views_, wanted_;  // shown; and asked for, where the camera moves on
    struct Moment {
        double time_s;
        std::vector<geom::View> views;
    };
    std::vector<Moment> past_;           // the last three, the latest last
    std::set<Block> asked_;              // ever
    std::vector<BlockRequest> pending_;  // with a budget: of the last batch, what is not there
    std::vector<uint64_t> rest_from_;    // by model: blocks before it are there
    StreamReport report_;
};

}  // namespace scene
