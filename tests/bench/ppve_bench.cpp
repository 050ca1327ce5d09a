// ppve_bench MESH [RUNS]: the server of remote point sampling on one mesh, view by view, as JSON lines:
// sampling, codecs, bytes.  Times are the least and the median of RUNS (default 5) interleaved ones,
// milliseconds; 1280x800, 40 degrees.
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/program.h"
#include "mesh/mesh.h"
#include "ppve/codec.h"
#include "ppve/sample/raster_sampler.h"
#include "ppve/session.h"

namespace {

using core::Json;

struct Scene {
    glm::dvec3 centre;
    double radius;
    glm::dvec3 up;
};

// All in view, twice as near, close by, and along the surface.
std::vector<std::pair<std::string, geom::Camera>> views_of(const Scene& s) {
    const glm::dvec3 side = std::abs(s.up.z) > 0.5 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
    const double fit = 0.62 * s.radius / std::sin(20 * std::numbers::pi / 180);
    const glm::dvec3 slant = glm::normalize(0.8 * side + 0.6 * s.up);
    const auto camera = [&](const glm::dvec3& eye, const glm::dvec3& target) {
        geom::Camera c;
        c.eye = eye, c.target = target, c.up = s.up, c.fovy_deg = 40;
        return c;
    };
    return {{"orbit", camera(s.centre + fit * slant, s.centre)},
            {"half", camera(s.centre + 0.5 * fit * slant, s.centre)},
            {"close", camera(s.centre + 0.12 * fit * slant + 0.1 * s.radius * s.up, s.centre)},
            {"walk", camera(s.centre + 0.35 * s.radius * s.up + 0.6 * s.radius * side,
                            s.centre - 0.3 * s.radius * side)}};
}

double cpu_ms() {
    timespec now;
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

// By the clock, and of all threads' processors: on a machine that others use, too, the first says little.
struct Time {
    double ms, cpu_ms;
};

Time timed(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu = cpu_ms();
    work();
    return {std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count(),
            cpu_ms() - cpu};
}

struct Times {
    std::vector<double> ms, cpu_ms;
    void add(const Time& time) { ms.push_back(time.ms), cpu_ms.push_back(time.cpu_ms); }
    Json json() {
        std::sort(ms.begin(), ms.end()), std::sort(cpu_ms.begin(), cpu_ms.end());
        return {{"min", ms.front()}, {"median", ms[ms.size() / 2]}, {"cpu_min", cpu_ms.front()}};
    }
};

// One codec on one image, in one direction after the other.
void time_codec(const ppve::DepthImage& image, ppve::Codec codec, Times& encode, Times& decode,
                size_t& bytes) {
    std::vector<std::byte> coded;
    encode.add(timed([&] { coded = ppve::encode(image, codec); }));
    bytes = coded.size();
    ppve::DepthImage back;
    back.frustum = image.frustum;
    decode.add(timed([&] { ppve::decode(coded, codec, false, back); }));
    if (back.depth != image.depth || back.colour != image.colour)
        throw core::Error("a codec is not lossless");
}

Json measure(ppve::Sampler& sampler, const std::string& name, const geom::Camera& camera, int runs) {
    ppve::DepthImage image, exact;
    image.frustum.view = exact.frustum.view = geom::make_view(camera, 1280, 800);
    ppve::prepare(sampler, 0.01, image);
    ppve::prepare(sampler, 0, exact);
    sampler.sample(exact, false);
    Times sample[2], lzw[2], planes[2], planes_1[2], floats[2];
    size_t lzw_bytes = 0, planes_bytes = 0, float_bytes = 0;
    ppve::SampleCounts counts;
    for (int run = 0; run < runs; ++run) {
        core::set_thread_count(1);
        sample[0].add(timed([&] { counts = sampler.sample(image, false); }));
        time_codec(exact, ppve::Codec::lzw, lzw[0], lzw[1], lzw_bytes);
        time_codec(image, ppve::Codec::planes, planes_1[0], planes_1[1], planes_bytes);
        core::set_thread_count(0);
        sample[1].add(timed([&] { sampler.sample(image, false); }));
        time_codec(image, ppve::Codec::planes, planes[0], planes[1], planes_bytes);
        time_codec(exact, ppve::Codec::planes, floats[0], floats[1], float_bytes);
    }
    return {{"view", name},
            {"pixels", image.samples()},
            {"mantissa_bits", image.coding.bits},
            {"bound_px", ppve::bound_px(image.coding, image.frustum.view.focal_px)},
            {"clusters_touched", counts.clusters_touched},
            {"clusters_hidden", counts.clusters_hidden},
            {"clusters", counts.clusters},
            {"triangles_tested", counts.triangles_tested},
            {"triangles_drawn", counts.triangles_drawn},
            {"bytes_touched", counts.bytes_touched},
            {"bytes", counts.bytes},
            {"sample_1_ms", sample[0].json()},
            {"sample_ms", sample[1].json()},
            {"lzw_bytes", lzw_bytes},
            {"planes_bytes", planes_bytes},
            {"exact_bytes", float_bytes},
            {"lzw_encode_ms", lzw[0].json()},
            {"lzw_decode_ms", lzw[1].json()},
            {"encode_1_ms", planes_1[0].json()},
            {"decode_1_ms", planes_1[1].json()},
            {"encode_ms", planes[0].json()},
            {"decode_ms", planes[1].json()},
            {"exact_encode_ms", floats[0].json()},
            {"exact_decode_ms", floats[1].json()}};
}

// A way of `steps` views from one camera to another and on: every update but the first finds most of its
// surface sent.
Json measure_updates(ppve::Sampler& sampler, const Scene& scene, int steps) {
    ppve::Session session(sampler, "scene", {});
    const auto views = views_of(scene);
    const geom::Camera from = views[1].second, to = views[3].second;
    Times whole, sample, eliminate, encode, insert;
    uint64_t bytes = 0, kept = 0, samples = 0;
    for (int n = 0; n < steps; ++n) {
        const double t = double(n) / 24;
        geom::Camera camera = from;
        camera.eye = glm::mix(from.eye, to.eye, t), camera.target = glm::mix(from.target, to.target, t);
        ppve::Request request;
        request.id = uint64_t(n) + 1;
        request.frustum.view = geom::make_view(camera, 1280, 800);
        session.take(request);
        ppve::AnswerReport report;
        const Time time = timed([&] { session.answer(report); });
        bytes += report.message_bytes, kept += report.elimination.kept, samples += report.elimination.samples;
        if (n == 0) continue;
        whole.add(time);
        for (const auto& [times, ms] : {std::pair{&sample, report.sample_ms},
                                        {&eliminate, report.eliminate_ms},
                                        {&encode, report.encode_ms},
                                        {&insert, report.insert_ms}})
            times->add({ms, 0});
    }
    return {{"view", "updates"},
            {"updates", steps},
            {"bytes_an_update", bytes / uint64_t(steps)},
            {"kept_share", double(kept) / double(samples)},
            {"points", session.tree().points()},
            {"update_ms", whole.json()},
            {"sample_ms", sample.json()},
            {"eliminate_ms", eliminate.json()},
            {"encode_ms", encode.json()},
            {"insert_ms", insert.json()}};
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("ppve_bench", "The server of remote point sampling on one mesh.", QS_VERSION);
    std::string path, up = "y";
    int64_t runs = 5;
    program.options.add_option("MESH", path, "Anything that qs-build reads")->required();
    program.options.add_option("--up", up, "y or z")->check(CLI::IsMember({"y", "z"}));
    program.add_integer("--runs", runs, 1, 1000, "Of each measurement");
    return program.run(argc, argv, [&] {
        ppve::RasterSampler sampler(ppve::Clusters(mesh::read_mesh(path).mesh));
        const ppve::Box box = sampler.bounds();
        const Scene scene{0.5 * (box.low + box.high), 0.5 * glm::length(box.high - box.low),
                          up == "z" ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0)};
        for (const auto& [name, camera] : views_of(scene))
            core::print(measure(sampler, name, camera, int(runs)).dump() + "\n");
        core::print(measure_updates(sampler, scene, std::max(3, int(runs))).dump() + "\n");
    });
}
