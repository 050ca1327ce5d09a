#include "render/splatter.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/parallel.h"
#include "render/splat_record.h"
#include "render/tile.h"

namespace render {
namespace {

// Splats of one task that touch one tile: order[begin..end) of the task.
struct Run {
    uint32_t tile, begin, end;
};

// One task's part of a frame.  Memory stays from frame to frame.
struct alignas(64) Task {
    std::vector<SplatRecord> records;  // the first `count` are this frame's
    size_t count = 0;
    PixelBox box;  // of the records
    std::vector<NearSplat> near_splats;
    std::vector<uint32_t> order;  // indices of records, tile by tile
    std::vector<Run> runs;
    std::vector<uint32_t> ends;  // scratch of the sort, one per tile of the task's part of the screen
};

// The tiles of a task's part of the screen, row by row.
struct TileGrid {
    int x0, y0, across, down;
};

// Calls body(place in `grid`) for each tile that the splat may touch.
template <class Body>
void for_each_tile(const SplatRecord& r, const TileGrid& grid, const Body& body) {
    const int x0 = int(uint32_t(r.x0) / kTileWidth) - grid.x0,
              x1 = int(uint32_t(r.x1) / kTileWidth) - grid.x0;
    const int y0 = int(uint32_t(r.y0) / kTileHeight) - grid.y0,
              y1 = int(uint32_t(r.y1) / kTileHeight) - grid.y0;
    // Nearly all lie in one.
    if (((x1 - x0) | (y1 - y0)) == 0) return body(size_t(y0 * grid.across + x0));
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) body(size_t(y * grid.across + x));
    }
}

// Counters of which the one used last is kept in a register: neighbours mostly lie in one tile, and
// counting in memory would wait for each store to come round to the next load.
class Counters {
  public:
    explicit Counters(std::vector<uint32_t>& values) : values_(values.data()), value_(values[0]) {}
    ~Counters() { values_[place_] = value_; }
    Counters(const Counters&) = delete;
    Counters& operator=(const Counters&) = delete;

    // The counter's value before it is raised by one.
    uint32_t next(size_t place) {
        if (place != place_) {
            values_[place_] = value_;
            place_ = place;
            value_ = values_[place];
        }
        return value_++;
    }

  private:
    uint32_t* values_;
    size_t place_ = 0;
    uint32_t value_;
};

// Counting sort of a task's splats into tiles; within a tile they keep their order.
void sort_into_tiles(Task& task, int tiles_across) {
    task.runs.clear();
    if (task.count == 0) return;
    TileGrid grid;
    grid.x0 = task.box.x0 / kTileWidth, grid.across = task.box.x1 / kTileWidth - grid.x0 + 1;
    grid.y0 = task.box.y0 / kTileHeight, grid.down = task.box.y1 / kTileHeight - grid.y0 + 1;
    task.ends.assign(size_t(grid.across) * size_t(grid.down), 0);
    {
        Counters counters(task.ends);
        for (size_t i = 0; i < task.count; ++i) {
            for_each_tile(task.records[i], grid, [&](size_t place) { counters.next(place); });
        }
    }
    uint32_t total = 0;
    for (size_t place = 0; place < task.ends.size(); ++place) {
        const uint32_t count = task.ends[place];
        task.ends[place] = total;
        if (count == 0) continue;
        const int x = grid.x0 + int(place) % grid.across, y = grid.y0 + int(place) / grid.across;
        task.runs.push_back({uint32_t(y * tiles_across + x), total, total + count});
        total += count;
    }
    if (task.order.size() < total) task.order.resize(total);
    Counters places(task.ends);
    uint32_t* order = task.order.data();
    for (size_t i = 0; i < task.count; ++i) {
        for_each_tile(task.records[i], grid,
                      [&](size_t place) { order[places.next(place)] = static_cast<uint32_t>(i); });
    }
}

struct alignas(64) TileState {
    float floats[kTileStateFloats];
};

// 1 / depth, both in units of the splats; `otherwise` where there is no depth.
float inverse_of(const std::optional<double>& depth, double unit, float otherwise) {
    if (!depth) return otherwise;
    return float(std::min(unit / *depth, double(std::numeric_limits<float>::max())));
}

}  // namespace

struct Splatter::State {
    SetupParams params;
    int tiles_across = 0, tiles_down = 0;
    size_t task_count = 0;
    std::vector<Task> tasks;

    // Filled by finish(): runs of all tasks, tile by tile, tasks in order.
    std::vector<uint32_t> run_begins;
    std::vector<TileRun> runs;
    std::vector<NearSplat> near_splats;
    tbb::enumerable_thread_specific<TileState> tile_states;

    void sort_runs();
    void fill_background(const TileJob& job, Frame& frame) const;
    void draw(size_t tile, Frame& frame);
};

Splatter::Splatter() : state_(std::make_unique<State>()) {}
Splatter::~Splatter() = default;

void Splatter::begin(const geom::View& view, const SplatterOptions& options, size_t task_count) {
    State& s = *state_;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    s.params = {view, options, inverse_of(view.far, options.depth_unit, -kInfinity),
                inverse_of(view.near, options.depth_unit, kInfinity)};
    s.tiles_across = (view.width + kTileWidth - 1) / kTileWidth;
    s.tiles_down = (view.height + kTileHeight - 1) / kTileHeight;
    s.task_count = task_count;
    if (s.tasks.size() < task_count) s.tasks.resize(task_count);
    for (size_t i = 0; i < task_count; ++i) {
        s.tasks[i].count = 0;
        s.tasks[i].box = {};
        s.tasks[i].near_splats.clear();
        s.tasks[i].runs.clear();
    }
}

void Splatter::add(size_t task_index, const SplatBatch& batch) {
    Task& task = state_->tasks[task_index];
    const size_t room = task.count + static_cast<size_t>(batch.count);
    if (task.records.size() < room) task.records.resize(std::max(room, 2 * task.records.size()));
    task.count +=
        set_up_splats(state_->params, batch, task.records.data() + task.count, task.box, task.near_splats);
}

void Splatter::end_task(size_t task_index) {
    sort_into_tiles(state_->tasks[task_index], state_->tiles_across);
}

// Counting sort once more, of the tasks' runs by tile; a few thousand.
void Splatter::State::sort_runs() {
    const size_t tiles = size_t(tiles_across) * size_t(tiles_down);
    run_begins.assign(tiles + 1, 0);
    near_splats.clear();
    for (size_t t = 0; t < task_count; ++t) {
        for (const Run& run : tasks[t].runs) ++run_begins[run.tile + 1];
        near_splats.insert(near_splats.end(), tasks[t].near_splats.begin(), tasks[t].near_splats.end());
    }
    for (size_t tile = 0; tile < tiles; ++tile) run_begins[tile + 1] += run_begins[tile];
    runs.resize(run_begins[tiles]);
    // From the last task down, so that run_begins[tile + 1] becomes the tile's.
    for (size_t t = task_count; t-- > 0;) {
        for (const Run& run : tasks[t].runs) {
            runs[--run_begins[run.tile + 1]] = {tasks[t].records.data(), tasks[t].order.data() + run.begin,
                                                run.end - run.begin};
        }
    }
}

void Splatter::State::fill_background(const TileJob& job, Frame& frame) const {
    const glm::u8vec3 c = params.options.background;
    for (int y = job.y0; y < job.y0 + job.height; ++y) {
        const size_t at = size_t(y) * size_t(frame.width) + size_t(job.x0);
        std::fill_n(frame.depth.begin() + static_cast<std::ptrdiff_t>(at), job.width,
                    std::numeric_limits<float>::infinity());
        uint8_t* out = frame.rgb.data() + 3 * at;
        if (c.r == c.g && c.g == c.b) {
            std::memset(out, c.r, size_t(job.width) * 3);
            continue;
        }
        for (int x = 0; x < job.width; ++x, out += 3) out[0] = c.r, out[1] = c.g, out[2] = c.b;
    }
}

void Splatter::State::draw(size_t tile, Frame& frame) {
    TileJob job;
    job.x0 = int(tile % size_t(tiles_across)) * kTileWidth;
    job.y0 = int(tile / size_t(tiles_across)) * kTileHeight;
    job.width = std::min(kTileWidth, frame.width - job.x0);
    job.height = std::min(kTileHeight, frame.height - job.y0);
    const size_t begin = run_begins[tile + 1];
    const size_t end = tile + 2 < run_begins.size() ? run_begins[tile + 2] : runs.size();
    job.runs = std::span(runs).subspan(begin, end - begin);
    job.near_splats = near_splats;
    if (job.runs.empty() && job.near_splats.empty()) return fill_background(job, frame);
    draw_tile(params, job, tile_states.local().floats, frame);
}

void Splatter::finish(Frame& frame) {
    State& s = *state_;
    const geom::View& view = s.params.view;
    const size_t pixels = size_t(view.width) * size_t(view.height);
    // Every pixel is written below; clearing them first would cost a tenth of a frame.
    if (frame.width != view.width || frame.height != view.height || frame.depth.size() != pixels ||
        frame.rgb.size() != 3 * pixels) {
        frame.resize(view.width, view.height);
    }
    s.sort_runs();
    core::parallel_for(size_t(s.tiles_across) * size_t(s.tiles_down),
                       [&](size_t tile) { s.draw(tile, frame); });
}

}  // namespace render
