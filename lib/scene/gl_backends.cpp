#include "scene/gl_backends.h"

#include "core/error.h"
#include "gl/splat_painter.h"

namespace scene {
namespace {

Backend backend_of(const char* name, std::unique_ptr<gl::Context> context) {
    auto device = std::make_unique<gl::Device>(std::move(context));
    std::string is = device->renderer() + ", OpenGL " + device->version();
    return {std::make_unique<gl::SplatPainter>(std::move(device)), name, std::move(is), ""};
}

}  // namespace

Backend open_osmesa() {
    return backend_of("osmesa", gl::make_osmesa_context());
}

Backend open_egl() {
    try {
        return backend_of("egl", gl::make_egl_context(gl::EglPlatform::device));
    } catch (const core::Error& of_devices) {
        try {
            return backend_of("egl", gl::make_egl_context(gl::EglPlatform::surfaceless));
        } catch (const core::Error& of_surfaceless) {
            if (std::string(of_devices.what()) == of_surfaceless.what()) throw;
            throw core::Error(std::string(of_devices.what()) +
                              "; without a device: " + of_surfaceless.what());
        }
    }
}

Backend open_egl_hardware() {
    auto device = std::make_unique<gl::Device>(gl::make_egl_context(gl::EglPlatform::hardware));
    if (device->is_software())
        throw core::Error("EGL draws in software, with " + device->renderer() + ", which is slower");
    const std::string is = device->renderer() + ", OpenGL " + device->version();
    return {std::make_unique<gl::SplatPainter>(std::move(device)), "egl", is,
            "EGL has a graphics processor, " + is};
}

}  // namespace scene
