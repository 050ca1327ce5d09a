// OSMesa: GL in software, into memory.
#include <GL/osmesa.h>

#include <array>

#include "core/error.h"
#include "gl/context.h"
#include "gl/library.h"

namespace gl {
namespace {

class OsMesaContext final : public Context {
  public:
    OsMesaContext()
        : library_("libOSMesa.so.8", "libosmesa6"),
          destroy_(library_.function<decltype(&OSMesaDestroyContext)>("OSMesaDestroyContext")),
          make_current_(library_.function<decltype(&OSMesaMakeCurrent)>("OSMesaMakeCurrent")),
          function_(library_.function<decltype(&OSMesaGetProcAddress)>("OSMesaGetProcAddress")) {
        const auto create =
            library_.function<decltype(&OSMesaCreateContextAttribs)>("OSMesaCreateContextAttribs");
        const int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  3,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  3,
                                  0};
        context_ = create(attributes, nullptr);
        if (!context_) throw core::Error("libOSMesa.so.8: makes no context of OpenGL 3.3");
    }

    ~OsMesaContext() override { destroy_(context_); }

    OsMesaContext(const OsMesaContext&) = delete;
    OsMesaContext& operator=(const OsMesaContext&) = delete;

    void make_current() override {
        // All drawing is into framebuffers of our own, but it wants a picture.
        if (!make_current_(context_, pixel_.data(), GL_UNSIGNED_BYTE, 1, 1))
            throw core::Error("libOSMesa.so.8: its context cannot be made current");
    }

    void release() override { make_current_(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

    void* function(const char* name) const override { return reinterpret_cast<void*>(function_(name)); }

  private:
    Library library_;
    decltype(&OSMesaDestroyContext) destroy_;
    decltype(&OSMesaMakeCurrent) make_current_;
    decltype(&OSMesaGetProcAddress) function_;
    OSMesaContext context_ = nullptr;
    std::array<unsigned char, 4> pixel_{};
};

}  // namespace

std::unique_ptr<Context> make_osmesa_context() {
    return std::make_unique<OsMesaContext>();
}

}  // namespace gl
