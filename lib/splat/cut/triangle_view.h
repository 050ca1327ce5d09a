// Triangles of leaves as a view has them: from runs to batches.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "geom/triangle_batch.h"
#include "splat/cut/cut_view.h"
#include "splat/triangle_run.h"

namespace splat {

// The corners of a run in view space.  A corner has the same bits in all runs that have it.
class RunInView {
  public:
    void see(const TriangleRun& run, const CutView& view);

    // Appends a triangle of that run, which must still be as it was, to a batch that has room; one without
    // area has nothing to show and is left out.
    void add(const TriangleRun& run, uint32_t triangle, uint32_t colour, geom::TriangleBatch& batch) const;

  private:
    glm::vec3 right_{0}, down_{0}, forward_{0};
    std::vector<float> at_[3], normal_[3];
};

}  // namespace splat
