#include "fetch/private_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cstdlib>
#include <string_view>

namespace fetch {

namespace {

void make_folders(const std::string& path) {
    for (size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
        const std::string part = path.substr(0, slash);
        if (::mkdir(part.c_str(), 0700) != 0 && errno != EEXIST) {
            // What cannot be made may be there all the same, on a read-only disk.
            const int reason = errno;
            struct stat status = {};
            if (::stat(part.c_str(), &status) != 0) {
                errno = reason;
                fail_with_errno(part, "cannot make the folder");
            }
        }
        if (slash == std::string::npos) return;
    }
}

}  // namespace

Descriptor open_private_folder(const std::string& path) {
    make_folders(path);
    Descriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder) fail_with_errno(path, "cannot open the folder");
    struct stat status = {};
    if (::fstat(folder.get(), &status) != 0) fail_with_errno(path, "cannot look at the folder");
    if (status.st_uid != ::geteuid())
        throw core::Error(core::text("%s: belongs to user %u, not to %u", path.c_str(),
                                     unsigned(status.st_uid), unsigned(::geteuid())));
    if (status.st_mode & 077)
        throw core::Error(core::text("%s: is open to others (mode %03o); close it by 'chmod 700'",
                                     path.c_str(), unsigned(status.st_mode & 0777)));
    return folder;
}

Descriptor lock_folder(int folder, const std::string& path) {
    const std::string name = path + "/lock";
    Descriptor lock(::openat(folder, "lock", O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!lock) fail_with_errno(name, "cannot open");
    char holder[32] = {};
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK) fail_with_errno(name, "cannot lock");
        const ssize_t length = ::pread(lock.get(), holder, sizeof holder - 1, 0);
        const std::string_view pid(holder, length > 0 ? size_t(length) : 0);
        throw core::Error(path + ": is in use by another qs-fetch, process " +
                          (pid.empty() ? "unknown" : std::string(pid)));
    }
    const std::string pid = std::to_string(::getpid());
    if (::ftruncate(lock.get(), 0) != 0 ||
        ::pwrite(lock.get(), pid.data(), pid.size(), 0) != ssize_t(pid.size()))
        fail_with_errno(name, "cannot write");
    return lock;
}

std::string default_folder() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache == '/')
        return std::string(cache) + "/qs-fetch";
    const char* home = std::getenv("HOME");
    if (!home || *home != '/')
        throw core::Error("neither XDG_CACHE_HOME nor HOME names a folder; give one with --cache");
    return std::string(home) + "/.cache/qs-fetch";
}

}  // namespace fetch
