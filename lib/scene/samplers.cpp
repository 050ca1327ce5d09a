#include "scene/samplers.h"

#include "core/error.h"
#include "core/file.h"
#include "ppve/sample/clusters.h"
#include "ppve/sample/embree_sampler.h"
#include "ppve/sample/raster_sampler.h"
#include "ppve/sample/volume_sampler.h"
#include "scene/gl_sampler.h"
#include "scene/surface_file.h"

namespace scene {

namespace {

// What is in the first file that only one sampler takes.
enum class Content { surface, volume, clusters };

Content content_of(const std::string& path) {
    // A pipe can be read once: it is a mesh.
    if (path == "-") return Content::surface;
    const core::InputFile file(path);
    const auto bytes = file.bytes();
    if (ppve::Clusters::is_file(bytes)) return Content::clusters;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return ppve::is_volume_header(text) ? Content::volume : Content::surface;
}

void refuse_others(const std::vector<std::string>& paths, const char* what) {
    if (paths.size() > 1)
        throw core::Error(paths.front() + ": " + what + " is sampled alone, without other files");
}

}  // namespace

std::unique_ptr<ppve::Sampler> open_sampler(const std::vector<std::string>& paths,
                                            const SamplerOptions& options) {
    switch (content_of(paths.front())) {
        case Content::volume:
            refuse_others(paths, "a volume");
            return std::make_unique<ppve::VolumeSampler>(ppve::Volume(paths.front()), options.iso);
        case Content::clusters:
            refuse_others(paths, "a file of clusters");
            if (options.kind != SamplerKind::raster)
                throw core::Error(paths.front() + ": clusters are for --sampler raster");
            return std::make_unique<ppve::RasterSampler>(ppve::Clusters(core::InputFile(paths.front())));
        case Content::surface:
            break;
    }
    mesh::Mesh mesh = read_surfaces(paths);
    if (options.kind == SamplerKind::raster)
        return std::make_unique<ppve::RasterSampler>(ppve::Clusters(mesh));
    if (options.kind == SamplerKind::embree) return ppve::open_embree_sampler(std::move(mesh));
    return open_gl_sampler(std::move(mesh), options.kind == SamplerKind::osmesa);
}

uint64_t write_clusters(const std::vector<std::string>& paths, const std::string& output) {
    const ppve::Clusters clusters(read_surfaces(paths));
    core::OutputFile out(output);
    clusters.write(out);
    out.commit();
    return clusters.bytes();
}

}  // namespace scene
