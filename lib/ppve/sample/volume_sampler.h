// The isosurface of a volume, by casting a ray a pixel: no mesh is made.
//
// Between the samples the volume is trilinear; along a ray through a cell that is a cubic, whose first root
// is found exactly (up to rounding), so that the surface has no holes and is the same from all sides.  Bricks
// of cells whose values are all on one side are stepped over.
//
// Marmitt and others.  Fast and accurate ray-voxel intersection techniques for iso-surface ray tracing. 2004.
#pragma once

#include <memory>

#include "ppve/sample/volume.h"
#include "ppve/sampler.h"

namespace ppve {

class VolumeSampler final : public Sampler {
  public:
    // The surface where the volume is `iso`.
    VolumeSampler(Volume volume, double iso);
    ~VolumeSampler() override;

    std::string name() const override { return "volume"; }
    Box bounds() const override;
    SampleCounts sample(DepthImage& image, bool with_normals) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ppve
