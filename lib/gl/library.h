// A shared library that is loaded at run time, so that nothing needs it to start.
#pragma once

#include <string>

namespace gl {

// Stays loaded until the process ends: drivers leave threads and exit handlers behind.
class Library {
  public:
    // `file` as the dynamic linker knows it; `package` is where Debian has it.  Throws core::Error with the
    // linker's reason.
    Library(const std::string& file, const std::string& package);

    // Throws core::Error where the library has no such function.
    template <class Function>
    Function function(const char* name) const {
        return reinterpret_cast<Function>(find(name));
    }

  private:
    void* find(const char* name) const;

    std::string file_;
    void* handle_;
};

}  // namespace gl
