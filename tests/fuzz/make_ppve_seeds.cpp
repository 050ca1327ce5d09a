// make_ppve_seeds FOLDER: the seeds of the fuzz targets of remote point sampling, in the folders
// corpus/ppve_*.
#include <cstdio>
#include <fstream>

#include "core/error.h"
#include "core/file.h"
#include "ppve/messages.h"
#include "ppve/sample/raster_sampler.h"

namespace {

void write(const std::string& path, std::span<const std::byte> bytes) {
    core::OutputFile out(path);
    out.write(bytes);
    out.commit();
}

mesh::Mesh tetrahedron() {
    mesh::Mesh mesh;
    mesh.positions = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    mesh.colours = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    return mesh;
}

ppve::Request request() {
    ppve::Request r;
    r.id = 2, r.stamp = 3, r.last_answer = 1, r.deletions = {1, 9};
    geom::Camera camera;
    camera.eye = {0, 0, 5}, camera.near = 0.1, camera.far = 100;
    r.frustum.view = geom::make_view(camera, 24, 16);
    return r;
}

void write_codec(const std::string& path, const ppve::DepthImage& image, ppve::Codec codec) {
    std::vector<std::byte> bytes = {std::byte(image.width() - 1), std::byte(image.height() - 1),
                                    std::byte(uint8_t(codec) | (image.normal.empty() ? 0 : 2))};
    const auto coded = ppve::encode(image, codec);
    bytes.insert(bytes.end(), coded.begin(), coded.end());
    write(path, bytes);
}

void write_seeds(const std::string& folder) {
    const ppve::Clusters clusters(tetrahedron());
    core::OutputFile file(folder + "/ppve_clusters/tetrahedron.clusters");
    clusters.write(file);
    file.commit();
    ppve::RasterSampler sampler{ppve::Clusters(tetrahedron())};
    ppve::Answer answer;
    answer.id = 2, answer.deleted = {9}, answer.frustum = request().frustum;
    for (const bool normals : {false, true})
        for (const auto codec : {ppve::Codec::planes, ppve::Codec::lzw}) {
            ppve::DepthImage image;
            image.frustum = answer.frustum;
            ppve::prepare(sampler, 0.01, image);
            sampler.sample(image, normals);
            const std::string name =
                std::string(codec == ppve::Codec::lzw ? "lzw" : "planes") + (normals ? "-normals" : "");
            write_codec(folder + "/ppve_codec/" + name, image, codec);
            answer.coding = image.coding, answer.codec = codec, answer.has_normals = normals;
            answer.image = ppve::encode(image, codec);
            write(folder + "/ppve_messages/answer-" + name, ppve::format(answer));
        }
    ppve::Welcome welcome;
    welcome.bounds = sampler.bounds(), welcome.most_pixels = 1000, welcome.most_points = 1000;
    welcome.scene = "tetrahedron.ply", welcome.sampler = "raster";
    write(folder + "/ppve_messages/welcome", ppve::format(welcome));
    write(folder + "/ppve_messages/request", ppve::format(request()));
    write(folder + "/ppve_messages/deletions", ppve::format(ppve::Deletions{{9}}));
    write(folder + "/ppve_messages/status-query", ppve::format(ppve::StatusQuery{}));
    write(folder + "/ppve_messages/status", ppve::format(ppve::Status{R"({"updates":1})"}));
    write(folder + "/ppve_messages/refusal", ppve::format(ppve::Refusal{2, "a newer request has come"}));
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 2) throw core::UsageError("usage: make_ppve_seeds FOLDER");
        write_seeds(argv[1]);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "make_ppve_seeds: %s\n", e.what());
        return 1;
    }
}
