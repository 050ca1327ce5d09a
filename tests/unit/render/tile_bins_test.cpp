// Splats are sorted into tiles before they are set up, by a bound on their outlines.
#include "render/tile_bins.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>

#include "render/splat_record.h"

using namespace render;

namespace {

struct Binned {
    std::vector<TileRun> runs;
    std::vector<NearSplat> near_splats;
    std::set<uint32_t> tiles() const {
        std::set<uint32_t> all;
        for (const TileRun& run : runs) all.insert(run.tile);
        return all;
    }
};

Binned bin(const SetupParams& params, const SplatBatch& batch, TileBins& bins) {
    Binned binned;
    bin_splats(params, batch, bins, binned.runs, binned.near_splats);
    bins.end_task(binned.runs);
    return binned;
}

// From far away to so close that its sphere all but reaches the eye's plane or goes beyond it, on the screen
// or beside it, and as often as not seen on edge.
void put_random_splat(std::mt19937& random, SplatBatch& batch) {
    std::uniform_real_distribution<float> part(-1, 1);
    const float z = std::exp2(8 * part(random));
    batch.count = 1;
    batch.x[0] = 2 * part(random) * z, batch.y[0] = 1.2f * part(random) * z, batch.z[0] = z;
    batch.radius[0] = z * std::exp2(6 * part(random) - 6.9f);
    glm::vec3 normal(part(random), part(random), part(random));
    const glm::vec3 ray(batch.x[0], batch.y[0], z);
    if (random() & 1) normal = glm::cross(normal, ray);
    normal = glm::normalize(normal);
    batch.nx[0] = normal.x, batch.ny[0] = normal.y, batch.nz[0] = normal.z;
    batch.flatness[0] = random() & 1 ? 0.03f : 0.5f + 0.5f * std::fabs(part(random));
    batch.colour[0] = random() & 0xffffffu;
}

std::set<uint32_t> tiles_of(const SplatRecord& r, int tiles_across) {
    std::set<uint32_t> tiles;
    for (int y = r.y0 / kTileHeight; y <= r.y1 / kTileHeight; ++y)
        for (int x = r.x0 / kTileWidth; x <= r.x1 / kTileWidth; ++x)
            tiles.insert(uint32_t(y * tiles_across + x));
    return tiles;
}

}  // namespace

TEST(TileBins, HaveEachSplatInAllTilesThatItsRecordNames) {
    std::mt19937 random(1);
    const auto batch = std::make_unique<SplatBatch>();
    const auto chunk = std::make_unique<SplatChunk>();
    const auto colours = std::make_unique<ColourChunk>();
    ChunkStore store;
    TileBins bins(store);
    size_t drawn = 0, dropped = 0, wide = 0;
    for (const SplatKind kind : {SplatKind::smooth, SplatKind::square}) {
        SetupParams params;
        params.view.width = 1280, params.view.height = 720, params.view.focal_px = 700;
        params.options.kind = kind;
        for (int i = 0; i < 50000; ++i) {
            store.begin();
            bins.begin(1280 / kTileWidth, (720 + kTileHeight - 1) / kTileHeight);
            put_random_splat(random, *batch);
            const SplatBatch& b = *batch;
            const float place[4] = {b.x[0], b.y[0], b.z[0], b.radius[0]};
            const float facing[4] = {b.nx[0], b.ny[0], b.nz[0], b.flatness[0]};
            std::copy_n(place, 4, chunk->place), std::copy_n(facing, 4, chunk->facing);
            colours->of[0] = b.colour[0];
            SplatRecord record;
            std::vector<NearSplat> near_splats;
            const bool visible = set_up_splats(params, *chunk, *colours, 1, &record, near_splats) == 1;
            const Binned binned = bin(params, b, bins);
            ASSERT_EQ(binned.near_splats.size(), near_splats.size()) << i;
            const std::set<uint32_t> found = binned.tiles();
            dropped += found.empty();
            if (!visible) continue;
            ++drawn;
            const std::set<uint32_t> wanted = tiles_of(record, bins.tiles_across());
            wide += wanted.size() > 1;
            ASSERT_TRUE(std::includes(found.begin(), found.end(), wanted.begin(), wanted.end())) << i;
        }
    }
    EXPECT_GT(drawn, 10000u);
    EXPECT_GT(dropped, 10000u);
    EXPECT_GT(wide, 2500u);
}

TEST(TileBins, KeepTheOrderOfSplatsAndForgetTheLastFrame) {
    SetupParams params;
    params.view.width = 128, params.view.height = 32, params.view.focal_px = 100;
    params.options.has_colour = true;
    const auto batch = std::make_unique<SplatBatch>();
    batch->count = 500;
    for (int i = 0; i < batch->count; ++i) {
        // The middle of one or the other of two tiles.
        batch->x[i] = i % 3 ? 3.2f : -3.2f, batch->y[i] = 0, batch->z[i] = 10, batch->radius[i] = 0.1f;
        batch->nx[i] = batch->ny[i] = 0, batch->nz[i] = -1, batch->flatness[i] = 0.1f;
        batch->colour[i] = uint32_t(i);
    }
    ChunkStore store;
    TileBins bins(store);
    for (int frame = 0; frame < 2; ++frame) {
        store.begin();
        bins.begin(2, 1);
        for (int task = 0; task < 3; ++task) {
            const Binned binned = bin(params, *batch, bins);
            std::vector<uint32_t> colours[2];
            for (const TileRun& run : binned.runs)
                for (uint32_t k = 0; k < run.count; ++k) colours[run.tile].push_back(run.colours->of[k]);
            ASSERT_EQ(colours[0].size() + colours[1].size(), 500u);
            for (uint32_t tile = 0; tile < 2; ++tile) {
                EXPECT_TRUE(std::is_sorted(colours[tile].begin(), colours[tile].end()));
                for (const uint32_t colour : colours[tile]) EXPECT_EQ(colour % 3 != 0, tile == 1);
            }
        }
    }
}
