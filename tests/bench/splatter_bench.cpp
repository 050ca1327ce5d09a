// What a frame of splats costs by stage: tangent discs on a bumpy sphere that fills the picture's height,
// in spatially coherent order, in 300 tasks.  Prints the least of many frames in milliseconds of
// wall time and of processor time.  Then the same for triangles of that size on the sphere, and for discs
// that hold one each.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "render/splatter.h"

namespace {

using render::SplatBatch;
using render::TriangleBatch;

constexpr size_t kTasks = 300;

struct Scene {
    std::vector<std::vector<SplatBatch>> tasks;
    size_t splats = 0;
};

// Bands of a spiral are not coherent in both directions; a grid of 20 x 15 patches is.
Scene bumpy_sphere(int across, float focal_px, float diameter_px) {
    Scene scene;
    scene.tasks.resize(kTasks);
    const float distance = 4, radius = 360.0f / focal_px * distance;
    for (size_t task = 0; task < kTasks; ++task) {
        const int patch_x = int(task) % 20, patch_y = int(task) / 20;
        for (int j = across * patch_y / 15; j < across * (patch_y + 1) / 15; ++j) {
            for (int i = across * patch_x / 20; i < across * (patch_x + 1) / 20; ++i) {
                const float u = 2 * (float(i) + 0.3f * float(j % 3)) / float(across) - 1;
                const float v = 2 * float(j) / float(across) - 1;
                const float rest = 1 - u * u - v * v;
                if (rest <= 0.01f) continue;
                glm::vec3 n = glm::normalize(
                    glm::vec3(u + 0.2f * std::sin(40 * v), v + 0.2f * std::sin(37 * u), -std::sqrt(rest)));
                std::vector<SplatBatch>& batches = scene.tasks[task];
                if (batches.empty() || batches.back().count == SplatBatch::kCapacity)
                    batches.emplace_back().count = 0;
                SplatBatch& b = batches.back();
                const size_t k = size_t(b.count++);
                b.x[k] = radius * u, b.y[k] = radius * v, b.z[k] = distance - radius * std::sqrt(rest);
                b.nx[k] = n.x, b.ny[k] = n.y, b.nz[k] = n.z;
                b.radius[k] = 0.5f * diameter_px * (0.7f + 0.6f * float((i * 7 + j * 13) % 11) / 11) *
                              b.z[k] / focal_px;
                b.flatness[k] = 0.08f;
                b.colour[k] = 0x806040;
                ++scene.splats;
            }
        }
    }
    return scene;
}

// Two triangles a square, right-angled on the screen, whose longest sides are the diameter; and their discs.
struct MeshScene {
    Scene discs;
    std::vector<std::vector<TriangleBatch>> tasks;
};

template <class Batch>
Batch& batch_with_room(std::vector<Batch>& batches) {
    if (batches.empty() || batches.back().count == Batch::kCapacity) batches.emplace_back().count = 0;
    return batches.back();
}

MeshScene meshed_sphere(float focal_px, float diameter_px) {
    MeshScene scene;
    scene.discs.tasks.resize(kTasks), scene.tasks.resize(kTasks);
    const float distance = 4, radius = 360.0f / focal_px * distance;
    const int across = int(720 / (diameter_px / std::sqrt(2.0f)));
    const auto corner = [&](int i, int j) {
        const float u = 2 * float(i) / float(across) - 1, v = 2 * float(j) / float(across) - 1;
        return glm::vec3(u, v, -std::sqrt(std::max(1 - u * u - v * v, 0.0f)));
    };
    const auto add = [&](size_t task, const glm::vec3(&n)[3]) {
        glm::vec3 p[3];
        for (int k = 0; k < 3; ++k) p[k] = glm::vec3(0, 0, distance) + radius * n[k];
        TriangleBatch& t = batch_with_room(scene.tasks[task]);
        const size_t at = size_t(t.count++);
        for (int k = 0; k < 3; ++k) {
            t.x[k][at] = p[k].x, t.y[k][at] = p[k].y, t.z[k][at] = p[k].z;
            t.nx[k][at] = n[k].x, t.ny[k][at] = n[k].y, t.nz[k][at] = n[k].z;
        }
        SplatBatch& d = batch_with_room(scene.discs.tasks[task]);
        const size_t k = size_t(d.count++);
        const glm::vec3 middle = 0.5f * (p[1] + p[2]), facing = glm::normalize(n[0] + n[1] + n[2]);
        d.x[k] = middle.x, d.y[k] = middle.y, d.z[k] = middle.z;
        d.nx[k] = facing.x, d.ny[k] = facing.y, d.nz[k] = facing.z;
        d.radius[k] = 0.5f * glm::distance(p[1], p[2]), d.flatness[k] = 0.03f;
        d.colour[k] = t.colour[at] = 0x806040;
        ++scene.discs.splats;
    };
    for (size_t task = 0; task < kTasks; ++task) {
        const int patch_x = int(task) % 20, patch_y = int(task) / 20;
        for (int j = across * patch_y / 15; j < across * (patch_y + 1) / 15; ++j) {
            for (int i = across * patch_x / 20; i < across * (patch_x + 1) / 20; ++i) {
                const glm::vec3 a = corner(i, j), b = corner(i + 1, j), c = corner(i, j + 1),
                                d = corner(i + 1, j + 1);
                if (a.z > -0.1f || b.z > -0.1f || c.z > -0.1f || d.z > -0.1f) continue;
                add(task, {a, b, c});
                add(task, {d, c, b});
            }
        }
    }
    return scene;
}

struct Times {
    double wall_ms, cpu_ms;
};

Times now() {
    timespec cpu;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    const auto wall =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch());
    return {wall.count(), 1e3 * double(cpu.tv_sec) + 1e-6 * double(cpu.tv_nsec)};
}

void take_least(Times& least, const Times& from, const Times& to) {
    least.wall_ms = std::min(least.wall_ms, to.wall_ms - from.wall_ms);
    least.cpu_ms = std::min(least.cpu_ms, to.cpu_ms - from.cpu_ms);
}

template <class Batch>
void measure(const char* name, const render::SplatterOptions& options, int frames,
             const std::vector<std::vector<Batch>>& tasks) {
    geom::View view;
    view.width = 1280, view.height = 720, view.focal_px = 1000;
    render::Splatter splatter;
    render::Frame frame;
    const Times most{1e9, 1e9};
    Times sort = most, draw = most, all = most;
    for (int i = 0; i < frames; ++i) {
        const Times start = now();
        splatter.begin(view, options, kTasks);
        core::parallel_for(kTasks, [&](size_t task) {
            for (const Batch& batch : tasks[task]) splatter.add(task, batch);
            splatter.end_task(task);
        });
        const Times sorted = now();
        splatter.finish(frame);
        const Times end = now();
        take_least(sort, start, sorted);
        take_least(draw, sorted, end);
        take_least(all, start, end);
    }
    size_t covered = 0;
    for (const float depth : frame.depth) covered += std::isfinite(depth);
    std::printf("%-16s sort %5.2f, set up, draw and shade %5.2f, all %5.2f ms; processor %5.2f ms; %zu px\n",
                name, sort.wall_ms, draw.wall_ms, all.wall_ms, all.cpu_ms, covered);
}

}  // namespace

// splatter_bench [DIAMETER_PX [SPLATS_ACROSS [FRAMES [THREADS]]]]
int main(int argc, char** argv) {
    const float diameter_px = argc > 1 ? float(std::atof(argv[1])) : 3.0f;
    const int across = argc > 2 ? std::atoi(argv[2]) : 545;
    const int frames = argc > 3 ? std::atoi(argv[3]) : 100;
    core::set_thread_count(argc > 4 ? std::atoi(argv[4]) : 0);
    const Scene scene = bumpy_sphere(across, 1000, diameter_px);
    std::printf("%zu splats of about %g px, %d threads\n", scene.splats, double(diameter_px),
                core::thread_count());

    const struct {
        const char* name;
        render::SplatKind kind;
        bool colour;
    } modes[] = {{"square", render::SplatKind::square, false},
                 {"ellipse", render::SplatKind::ellipse, false},
                 {"smooth", render::SplatKind::smooth, false},
                 {"smooth, colour", render::SplatKind::smooth, true}};
    for (const auto& mode : modes) measure(mode.name, {mode.kind, {}, mode.colour}, frames, scene.tasks);

    const MeshScene mesh = meshed_sphere(1000, diameter_px);
    std::printf("%zu triangles of about %g px\n", mesh.discs.splats, double(diameter_px));
    measure("triangles", {render::SplatKind::smooth, {}, false}, frames, mesh.tasks);
    measure("triangles, colour", {render::SplatKind::smooth, {}, true}, frames, mesh.tasks);
    measure("discs, ellipse", {render::SplatKind::ellipse, {}, false}, frames, mesh.discs.tasks);
    measure("discs, smooth", {render::SplatKind::smooth, {}, false}, frames, mesh.discs.tasks);
}
