#include "core/error.h"
#include "scene/gl_sampler.h"

namespace scene {

std::unique_ptr<ppve::Sampler> open_gl_sampler(mesh::Mesh, bool) {
    throw core::Error("this build samples without OpenGL (-DQS_GL=ON)");
}

}  // namespace scene
