#include "gl/device.h"

#include <algorithm>
#include <array>

#include "core/error.h"

namespace gl {
namespace {

std::string string_of(const Functions& gl, GLenum name) {
    const GLubyte* const text = gl.GetString(name);
    return text ? reinterpret_cast<const char*>(text) : "unknown";
}

bool names_software(const std::string& renderer) {
    constexpr std::array kSoftware{"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SWR"};
    return std::any_of(kSoftware.begin(), kSoftware.end(),
                       [&](const char* word) { return renderer.find(word) != renderer.npos; });
}

const char* name_of_error(GLenum error) {
    switch (error) {
        case GL_OUT_OF_MEMORY:
            return "out of memory";
        case GL_INVALID_ENUM:
            return "invalid enum";
        case GL_INVALID_VALUE:
            return "invalid value";
        case GL_INVALID_OPERATION:
            return "invalid operation";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "invalid framebuffer operation";
        default:
            return "unknown error";
    }
}

}  // namespace

Functions::Functions(const Context& context) {
#define QS_GL_LOAD(name, type)                                   \
    name = reinterpret_cast<type>(context.function("gl" #name)); \
    if (!(name)) throw core::Error("GL has no function gl" #name);
    QS_GL_FUNCTIONS(QS_GL_LOAD)
#undef QS_GL_LOAD
}

Device::Device(std::unique_ptr<Context> context) : context_(std::move(context)) {
    context_->make_current();
    functions_ = std::make_unique<Functions>(*context_);
    const Functions& gl = *functions_;
    renderer_ = string_of(gl, GL_RENDERER);
    version_ = string_of(gl, GL_VERSION);
    is_software_ = names_software(renderer_);
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest_texture_);
    std::array<float, 2> sizes{};
    gl.GetFloatv(GL_POINT_SIZE_RANGE, sizes.data());
    largest_point_ = sizes[1];
    context_->release();
}

Use::Use(const Device& device) : device_(device) {
    device_.context_->make_current();
}

Use::~Use() {
    device_.context_->release();
}

void Use::check(const std::string& what) const {
    const GLenum error = (*this)->GetError();
    if (error != GL_NO_ERROR)
        throw core::Error(device_.renderer_ + ": " + name_of_error(error) + " while " + what);
}

}  // namespace gl
