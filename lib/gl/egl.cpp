// EGL: GL of a graphics processor, or of a software renderer that stands in for one.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "gl/context.h"
#include "gl/library.h"

namespace gl {
namespace {

constexpr const char* kLibrary = "libEGL.so.1";

core::Error failure(const std::string& what) {
    return core::Error(std::string(kLibrary) + ": " + what);
}

// True if `word` is one of those in `list`, which may be null.
bool has_word(const char* list, std::string_view word) {
    std::istringstream words(list ? list : "");
    return std::find(std::istream_iterator<std::string>(words), {}, word) !=
           std::istream_iterator<std::string>();
}

struct Egl {
    Library library{kLibrary, "libegl1"};
    PFNEGLGETPROCADDRESSPROC function = library.function<PFNEGLGETPROCADDRESSPROC>("eglGetProcAddress");
    PFNEGLQUERYSTRINGPROC query_string = library.function<PFNEGLQUERYSTRINGPROC>("eglQueryString");
    PFNEGLINITIALIZEPROC initialize = library.function<PFNEGLINITIALIZEPROC>("eglInitialize");
    PFNEGLBINDAPIPROC bind_api = library.function<PFNEGLBINDAPIPROC>("eglBindAPI");
    PFNEGLCREATECONTEXTPROC create_context = library.function<PFNEGLCREATECONTEXTPROC>("eglCreateContext");
    PFNEGLDESTROYCONTEXTPROC destroy_context =
        library.function<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext");
    PFNEGLMAKECURRENTPROC make_current = library.function<PFNEGLMAKECURRENTPROC>("eglMakeCurrent");
    PFNEGLGETERRORPROC error = library.function<PFNEGLGETERRORPROC>("eglGetError");

    void require(const char* extensions, std::initializer_list<const char*> words) const {
        for (const char* word : words)
            if (!has_word(extensions, word)) throw failure(std::string("lacks ") + word);
    }

    template <class Function>
    Function extension(const char* name) const {
        const auto found = reinterpret_cast<Function>(function(name));
        if (!found) throw failure(std::string("has no function ") + name);
        return found;
    }

    std::string error_text() const { return core::text("error 0x%04x", unsigned(error())); }
};

class EglContext final : public Context {
  public:
    EglContext(const Egl& egl, EGLDisplay display) : egl_(egl), display_(display) {
        // A display is never terminated: it is the process's, and may be another context's.
        if (!egl_.initialize(display_, nullptr, nullptr))
            throw failure("the display cannot be initialised, " + egl_.error_text());
        egl_.require(egl_.query_string(display_, EGL_EXTENSIONS),
                     {"EGL_KHR_create_context", "EGL_KHR_no_config_context", "EGL_KHR_surfaceless_context"});
        if (!egl_.bind_api(EGL_OPENGL_API)) throw failure("has no desktop OpenGL");
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                                     3,
                                     EGL_CONTEXT_MINOR_VERSION_KHR,
                                     3,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                     EGL_NONE};
        context_ = egl_.create_context(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
        if (context_ == EGL_NO_CONTEXT) throw failure("makes no context of OpenGL 3.3, " + egl_.error_text());
    }

    ~EglContext() override { egl_.destroy_context(display_, context_); }

    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    void make_current() override {
        egl_.bind_api(EGL_OPENGL_API);  // is the thread's
        if (!egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            throw failure("its context cannot be made current, " + egl_.error_text());
    }

    void release() override { egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

    void* function(const char* name) const override { return reinterpret_cast<void*>(egl_.function(name)); }

  private:
    Egl egl_;
    EGLDisplay display_;
    EGLContext context_ = EGL_NO_CONTEXT;
};

EGLDisplay platform_display(const Egl& egl, EGLenum platform, void* native) {
    const auto get = egl.extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const EGLDisplay display = get(platform, native, nullptr);
    if (display == EGL_NO_DISPLAY) throw failure("gives no display, " + egl.error_text());
    return display;
}

struct Device {
    EGLDeviceEXT id;
    bool is_software;
};

// Those that are not software come first.
std::vector<Device> devices(const Egl& egl, const char* extensions) {
    egl.require(extensions,
                {"EGL_EXT_device_enumeration", "EGL_EXT_device_query", "EGL_EXT_platform_device"});
    constexpr EGLint kMost = 64;
    std::vector<EGLDeviceEXT> ids(kMost);
    EGLint count = 0;
    if (!egl.extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT")(kMost, ids.data(), &count))
        throw failure("names no devices, " + egl.error_text());
    const auto query = egl.extension<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    std::vector<Device> found;
    for (const bool is_software : {false, true})
        for (EGLint i = 0; i < count; ++i) {
            const EGLDeviceEXT id = ids[size_t(i)];
            if (has_word(query(id, EGL_EXTENSIONS), "EGL_MESA_device_software") == is_software)
                found.push_back({id, is_software});
        }
    return found;
}

}  // namespace

std::unique_ptr<Context> make_egl_context(EglPlatform platform) {
    const Egl egl;
    const char* const extensions = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    egl.require(extensions, {"EGL_EXT_platform_base"});
    if (platform == EglPlatform::surfaceless) {
        egl.require(extensions, {"EGL_MESA_platform_surfaceless"});
        return std::make_unique<EglContext>(
            egl, platform_display(egl, EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY));
    }
    std::string reason = std::string(kLibrary) + ": names no device";
    for (const Device& device : devices(egl, extensions)) {
        if (platform == EglPlatform::hardware && device.is_software) {
            reason = std::string(kLibrary) + ": names no device but a software renderer";
            break;
        }
        try {
            return std::make_unique<EglContext>(egl,
                                                platform_display(egl, EGL_PLATFORM_DEVICE_EXT, device.id));
        } catch (const core::Error& error) {
            reason = error.what();  // the last one's
        }
    }
    throw core::Error(reason);
}

}  // namespace gl
