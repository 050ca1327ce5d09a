#include "core/error.h"

#include <cstdarg>
#include <cstdio>

namespace core {

std::string text(const char* format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int size = std::vsnprintf(nullptr, 0, format, arguments);
    va_end(arguments);
    std::string result(size > 0 ? static_cast<size_t>(size) : 0, '\0');
    if (size > 0) std::vsnprintf(result.data(), result.size() + 1, format, again);
    va_end(again);
    return result;
}

std::string wrong_checksum(uint64_t found, uint64_t stored, int digits) {
    return text("checksum %0*llx, stored is %0*llx; bytes of the file are damaged: copy or build it again",
                digits, static_cast<unsigned long long>(found), digits,
                static_cast<unsigned long long>(stored));
}

}  // namespace core
