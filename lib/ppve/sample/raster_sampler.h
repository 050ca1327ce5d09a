// The default sampler: a mesh kept in clusters, rasterised exactly on all cores.
//
// The pixels that a triangle covers are those of render::MeshRaster, whose arithmetic decides wherever plain
// double precision is in doubt.  Clusters are drawn front to back in waves; between two waves a coarse
// pyramid of the farthest depths is made, by which later ones are left out as hidden: that changes no sample.
// Backs are not culled: a scan is seldom proved closed, and the eye may be inside.
//
// All threads draw into one buffer of 64-bit words, depth above colour, where the largest stays; so the image
// does not depend on who comes first.  Of samples with the same depth code the one with the largest colour
// shows.
#pragma once

#include <memory>

#include "ppve/sample/clusters.h"
#include "ppve/sampler.h"

namespace ppve {

class RasterSampler final : public Sampler {
  public:
    explicit RasterSampler(Clusters clusters);
    ~RasterSampler() override;

    std::string name() const override { return "raster"; }
    Box bounds() const override;
    SampleCounts sample(DepthImage& image, bool with_normals) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ppve
