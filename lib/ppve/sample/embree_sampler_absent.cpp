#include "core/error.h"
#include "ppve/sample/embree_sampler.h"

namespace ppve {

std::unique_ptr<Sampler> open_embree_sampler(mesh::Mesh) {
    throw core::Error("this build samples without Embree (-DQS_EMBREE=ON)");
}

}  // namespace ppve
