// Contexts of desktop OpenGL 3.3, core profile, without a window and without a display, made by libraries
// that are loaded at run time.
#pragma once

#include <memory>

namespace gl {

class Context {
  public:
    virtual ~Context() = default;

    // The calling thread's from now on, instead of what was; a context is one thread's at a time.  Throws
    // core::Error.
    virtual void make_current() = 0;
    virtual void release() = 0;

    // A function of GL, null where there is none; of use while the context is current.
    virtual void* function(const char* name) const = 0;
};

// How EGL is asked for its graphics processors.
enum class EglPlatform {
    device,    // one after the other: the first that is hardware, else the first
    hardware,  // likewise, but none that says of itself that it is software; costs little where there is none
    surfaceless  // what Mesa takes itself
};

// These throw core::Error where the library is not installed, or cannot do it, with its reason.
std::unique_ptr<Context> make_osmesa_context();
std::unique_ptr<Context> make_egl_context(EglPlatform platform);

}  // namespace gl
