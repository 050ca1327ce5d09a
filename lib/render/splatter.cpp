#include "render/splatter.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <mutex>
#include <utility>

#include "core/parallel.h"
#include "render/splat_record.h"
#include "render/tile.h"
#include "render/tile_triangles.h"

namespace render {
namespace {

// One task's part of a frame.  Memory stays from frame to frame.
struct alignas(64) Task {
    TileBins* bins = nullptr;  // while splats are added
    std::vector<TileRun> runs;
    TriangleBins* triangle_bins = nullptr;  // while triangles are added
    std::vector<TriangleRun> triangle_runs;
    std::vector<NearSplat> near_splats;
};

// Bins that tasks borrow: as many as there were tasks with splats, or triangles, at one time.
template <class Bins>
class Pool {
  public:
    void begin(const TileGrid& grid) {
        across_ = grid.across, down_ = grid.down;
        free_.clear();
        for (const auto& bins : all_) {
            bins->begin(across_, down_);
            free_.push_back(bins.get());
        }
    }

    // `args`: what new bins are made with.
    template <class... Args>
    Bins* take(Args&... args) {
        const std::scoped_lock lock(mutex_);
        if (free_.empty()) {
            all_.push_back(std::make_unique<Bins>(args...));
            all_.back()->begin(across_, down_);
            free_.push_back(all_.back().get());
        }
        Bins* taken = free_.back();
        free_.pop_back();
        return taken;
    }

    void give_back(Bins* bins) {
        const std::scoped_lock lock(mutex_);
        free_.push_back(bins);
    }

  private:
    int across_ = 0, down_ = 0;
    std::vector<std::unique_ptr<Bins>> all_;
    std::vector<Bins*> free_;  // those that no task has now
    std::mutex mutex_;         // of both
};

// The runs of all tasks, tile by tile, tasks in order.
template <class Run>
class RunsOfTiles {
  public:
    // Counting sort of `runs`, a member of the first `task_count` tasks; some thousands.
    void sort(const std::vector<Task>& tasks, size_t task_count, std::vector<Run> Task::*runs, size_t tiles) {
        begins_.assign(tiles + 1, 0);
        for (size_t t = 0; t < task_count; ++t)
            for (const Run& run : tasks[t].*runs) ++begins_[run.tile + 1];
        for (size_t tile = 0; tile < tiles; ++tile) begins_[tile + 1] += begins_[tile];
        runs_.resize(begins_[tiles]);
        // From the last down, so that begins_[tile + 1] becomes the tile's.
        for (size_t t = task_count; t-- > 0;) {
            const std::vector<Run>& of_task = tasks[t].*runs;
            for (size_t i = of_task.size(); i-- > 0;) runs_[--begins_[of_task[i].tile + 1]] = of_task[i];
        }
    }

    bool empty() const { return runs_.empty(); }

    std::span<const Run> of(size_t tile) const {
        const size_t begin = begins_[tile + 1];
        const size_t end = tile + 2 < begins_.size() ? begins_[tile + 2] : runs_.size();
        return std::span(runs_).subspan(begin, end - begin);
    }

  private:
    std::vector<uint32_t> begins_;
    std::vector<Run> runs_;
};

// 1 / depth, both in units of the splats; `otherwise` where there is no depth.
float inverse_of(const std::optional<double>& depth, double unit, float otherwise) {
    if (!depth) return otherwise;
    return float(std::min(unit / *depth, double(std::numeric_limits<float>::max())));
}

}  // namespace

SetupParams::SetupParams(const geom::View& seen, const SplatterOptions& wanted)
    : view(subdivided(seen, wanted.look.samples_across)),
      options(wanted),
      light(light_of(wanted.look, seen)) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    least_w = inverse_of(view.far, options.depth_unit, -kInfinity);
    most_w = inverse_of(view.near, options.depth_unit, kInfinity);
    triangle_lead = float(std::min(1 + options.push_back_px / seen.focal_px, 1.0e30));
}

struct Splatter::State {
    SetupParams params;
    TileGrid grid{{}};
    size_t task_count = 0;
    std::vector<Task> tasks;

    ChunkStore chunks;
    Pool<TileBins> bins;
    Pool<TriangleBins> triangle_bins;

    // Filled by finish().
    RunsOfTiles<TileRun> runs;
    RunsOfTiles<TriangleRun> triangle_runs;
    std::vector<NearSplat> near_splats;
    tbb::enumerable_thread_specific<TileScratch> scratches;
    tbb::enumerable_thread_specific<TriangleScratch> triangle_scratches;

    void sort_runs();
    void fill_background(const TileJob& job, Frame& frame) const;
    void finish(Frame& frame, geom::OcclusionMap* map);
    void draw(size_t tile, Frame& frame, geom::OcclusionMap* map);
};

Splatter::Splatter() : state_(std::make_unique<State>()) {}
Splatter::~Splatter() = default;

void Splatter::begin(const geom::View& view, const SplatterOptions& options, size_t task_count) {
    State& s = *state_;
    s.params = SetupParams(view, options);
    s.grid = TileGrid(s.params.view);
    s.task_count = task_count;
    if (s.tasks.size() < task_count) s.tasks.resize(task_count);
    for (size_t i = 0; i < task_count; ++i) {
        s.tasks[i].bins = nullptr;
        s.tasks[i].near_splats.clear();
        s.tasks[i].runs.clear();
        s.tasks[i].triangle_bins = nullptr;
        s.tasks[i].triangle_runs.clear();
    }
    s.chunks.begin();
    s.bins.begin(s.grid);
    s.triangle_bins.begin(s.grid);
}

void Splatter::add(size_t task_index, const SplatBatch& batch) {
    Task& task = state_->tasks[task_index];
    if (!task.bins) task.bins = state_->bins.take(state_->chunks);
    bin_splats(state_->params, batch, *task.bins, task.runs, task.near_splats);
}

void Splatter::add(size_t task_index, const TriangleBatch& batch) {
    Task& task = state_->tasks[task_index];
    if (!task.triangle_bins) task.triangle_bins = state_->triangle_bins.take();
    task.triangle_bins->add(state_->params, batch);
}

void Splatter::end_task(size_t task_index) {
    Task& task = state_->tasks[task_index];
    const auto end = [](auto*& bins, auto& runs, auto& pool) {
        if (!bins) return;
        bins->end_task(runs);
        pool.give_back(std::exchange(bins, nullptr));
    };
    end(task.bins, task.runs, state_->bins);
    end(task.triangle_bins, task.triangle_runs, state_->triangle_bins);
}

void Splatter::State::sort_runs() {
    runs.sort(tasks, task_count, &Task::runs, grid.count());
    triangle_runs.sort(tasks, task_count, &Task::triangle_runs, grid.count());
    near_splats.clear();
    for (size_t t = 0; t < task_count; ++t)
        near_splats.insert(near_splats.end(), tasks[t].near_splats.begin(), tasks[t].near_splats.end());
}

void Splatter::State::fill_background(const TileJob& job, Frame& frame) const {
    const Look& look = params.options.look;
    const glm::u8vec3 c = look.background;
    const int width = (job.right - job.left) / look.samples_across;
    const int height = (job.bottom - job.top) / look.samples_across;
    for (int y = 0; y < height; ++y) {
        const size_t at = job.frame_at + size_t(y) * size_t(frame.width);
        std::fill_n(frame.depth.begin() + static_cast<std::ptrdiff_t>(at), width,
                    std::numeric_limits<float>::infinity());
        if (look.has_alpha()) std::memset(frame.alpha.data() + at, look.background_alpha, size_t(width));
        uint8_t* out = frame.rgb.data() + 3 * at;
        if (c.r == c.g && c.g == c.b) {
            std::memset(out, c.r, size_t(width) * 3);
            continue;
        }
        for (int x = 0; x < width; ++x, out += 3) out[0] = c.r, out[1] = c.g, out[2] = c.b;
    }
}

// Tiles are made of whole blocks of the map.
static_assert(kTileWidth % geom::OcclusionMap::kBlock == 0 && kTileHeight % geom::OcclusionMap::kBlock == 0);

// Of the map's blocks in the tile, by a pixel of each that lies in the raster.
template <class Test>
bool any_block(const TileJob& job, const Test& test) {
    constexpr int kBlock = geom::OcclusionMap::kBlock;
    for (int y = job.top; y < job.bottom; y = (y / kBlock + 1) * kBlock)
        for (int x = job.left; x < job.right; x = (x / kBlock + 1) * kBlock)
            if (test(job.x0 + x, job.y0 + y)) return true;
    return false;
}

void Splatter::State::draw(size_t tile, Frame& frame, geom::OcclusionMap* map) {
    const geom::Margins& outside = params.view.margins;
    TileJob job;
    job.x0 = (grid.left + int(tile % size_t(grid.across))) * kTileWidth;
    job.y0 = (grid.top + int(tile / size_t(grid.across))) * kTileHeight;
    job.left = std::max(outside.left - job.x0, 0);
    job.top = std::max(outside.top - job.y0, 0);
    job.right = std::min(outside.left + params.view.width - job.x0, kTileWidth);
    job.bottom = std::min(outside.top + params.view.height - job.y0, kTileHeight);
    const int across = params.options.look.samples_across;
    job.frame_at = size_t((job.y0 + job.top - outside.top) / across) * size_t(frame.width) +
                   size_t((job.x0 + job.left - outside.left) / across);
    job.runs = runs.of(tile);
    job.near_splats = near_splats;
    if (map && map->is_repeated()) {
        if (!any_block(job, [&](int x, int y) { return map->is_unproven(x, y); })) return;
        job.map = map;
    } else if (map && any_block(job, [&](int x, int y) { return map->limit(x, y) > 0; })) {
        job.map = map;
    }
    if (const auto triangles = triangle_runs.of(tile); !triangles.empty()) {
        TriangleScratch& scratch = triangle_scratches.local();
        draw_triangles(params, job.x0, job.y0, triangles, scratch);
        job.triangles = &scratch.shown;
    }
    if (job.runs.empty() && job.near_splats.empty() && !job.triangles && !job.map)
        return fill_background(job, frame);
    draw_tile(params, job, scratches.local(), frame);
}

void Splatter::finish(Frame& frame) {
    state_->finish(frame, nullptr);
}
void Splatter::finish(Frame& frame, geom::OcclusionMap& map) {
    state_->finish(frame, &map);
}

void Splatter::State::finish(Frame& frame, geom::OcclusionMap* map) {
    const Look& look = params.options.look;
    const int width = params.view.width / look.samples_across;
    const int height = params.view.height / look.samples_across;
    const size_t pixels = size_t(width) * size_t(height);
    // Every pixel is written below; clearing them first would cost a tenth of a frame.
    if (frame.width != width || frame.height != height || frame.depth.size() != pixels ||
        frame.rgb.size() != 3 * pixels) {
        frame.resize(width, height);
    }
    frame.alpha.resize(look.has_alpha() ? pixels : 0);
    frame.depth_at = look.depth_at();
    sort_runs();
    assert(!map || triangle_runs.empty() || params.options.has_triangles);
    core::parallel_for(grid.count(), [&](size_t tile) { draw(tile, frame, map); });
}

}  // namespace render
