#include "gl/library.h"

#include <dlfcn.h>

#include <atomic>

#include "core/error.h"

#ifdef __SANITIZE_ADDRESS__
// When a program ends, the leak checker stops all its threads to read their stacks.  With those of a driver
// it crashes itself, once in some hundred times; what the driver keeps is not ours either.
static std::atomic<bool> has_driver{false};
extern "C" int __lsan_is_turned_off() {
    return has_driver;
}
#endif

namespace gl {

Library::Library(const std::string& file, const std::string& package)
    : file_(file), handle_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw core::Error(std::string(dlerror()) + " (Debian has it in " + package + ")");
#ifdef __SANITIZE_ADDRESS__
    has_driver = true;
#endif
}

void* Library::find(const char* name) const {
    void* const found = dlsym(handle_, name);
    if (!found) throw core::Error(file_ + ": has no function " + name);
    return found;
}

}  // namespace gl
