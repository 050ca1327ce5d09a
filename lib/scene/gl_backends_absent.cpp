// In place of gl_backends.cpp where QS_GL is off.
#include "core/error.h"
#include "scene/gl_backends.h"

namespace scene {
namespace {

Backend refuse() {
    throw core::Error("this build draws without OpenGL (QS_GL was off)");
}

}  // namespace

Backend open_osmesa() {
    return refuse();
}

Backend open_egl() {
    return refuse();
}

Backend open_egl_hardware() {
    return refuse();
}

}  // namespace scene
