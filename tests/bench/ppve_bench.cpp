// ppve_bench MESH [RUNS]: the server of remote point sampling on one mesh, view by view, as JSON lines:
// sampling, codecs, bytes.  Times are the least and the median of RUNS (default 5) interleaved ones,
// milliseconds; 1280x800, 40 degrees.
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
#include "ppve/raster_sampler.h"

namespace {

using core::Json;

struct Scene {
    glm::dvec3 centre;
    double radius;
    glm::dvec3 up;
};

// Those of the experiments: all in view, twice as near, close by, and along the surface.
std::vector<std::pair<std::string, geom::Camera>> views_of(const Scene& s) {
    const glm::dvec3 side = std::abs(s.up.z) > 0.5 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
    const double fit = s.radius / std::sin(20 * std::numbers::pi / 180);
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

double timed_ms(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

struct Times {
    std::vector<double> ms;
    Json json() {
        std::sort(ms.begin(), ms.end());
        return {{"min", ms.front()}, {"median", ms[ms.size() / 2]}};
    }
};

// One codec on one image, in one direction after the other.
void time_codec(const ppve::DepthImage& image, ppve::Codec codec, Times& encode, Times& decode,
                size_t& bytes) {
    std::vector<std::byte> coded;
    encode.ms.push_back(timed_ms([&] { coded = ppve::encode(image, codec); }));
    bytes = coded.size();
    ppve::DepthImage back;
    back.frustum = image.frustum;
    decode.ms.push_back(timed_ms([&] { ppve::decode(coded, codec, false, back); }));
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
        sample[0].ms.push_back(timed_ms([&] { counts = sampler.sample(image, false); }));
        time_codec(exact, ppve::Codec::lzw, lzw[0], lzw[1], lzw_bytes);
        time_codec(image, ppve::Codec::planes, planes_1[0], planes_1[1], planes_bytes);
        core::set_thread_count(0);
        sample[1].ms.push_back(timed_ms([&] { sampler.sample(image, false); }));
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
    });
}
