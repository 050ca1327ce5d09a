// The samplers that there are, by name, and what each is given.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ppve/sampler.h"

namespace scene {

// raster: ppve::RasterSampler.  egl, osmesa: OpenGL, see GlSampler.  embree: ray casting.  A .mhd volume has
// a sampler of its own, whatever is asked for: its isosurface.
enum class SamplerKind { raster, egl, osmesa, embree };

struct SamplerOptions {
    SamplerKind kind = SamplerKind::raster;
    double iso = 0;  // of a volume
};

// Reads the files (see surface_file.h; or one volume; or one file of clusters).  Throws core::Error where one
// cannot be read or the sampler is not to be had.
std::unique_ptr<ppve::Sampler> open_sampler(const std::vector<std::string>& paths,
                                            const SamplerOptions& options);

// Writes the clusters of meshes as a file, for open_sampler() to map.  Returns its size in bytes.
uint64_t write_clusters(const std::vector<std::string>& paths, const std::string& output);

}  // namespace scene
