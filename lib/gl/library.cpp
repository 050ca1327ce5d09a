#include "gl/library.h"

#include <dlfcn.h>

#include "core/error.h"

// What is loaded here is not built with sanitizers.
#ifdef __SANITIZE_ADDRESS__
// OSMesa keeps a list of its pictures, some hundred bytes a context, which it never frees.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libOSMesa.so\n";
}
extern "C" const char* __lsan_default_options() {
    return "print_suppressions=0";
}
#endif

namespace gl {

Library::Library(const std::string& file, const std::string& package)
    : file_(file), handle_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw core::Error(std::string(dlerror()) + " (Debian has it in " + package + ")");
}

void* Library::find(const char* name) const {
    void* const found = dlsym(handle_, name);
    if (!found) throw core::Error(file_ + ": has no function " + name);
    return found;
}

}  // namespace gl
