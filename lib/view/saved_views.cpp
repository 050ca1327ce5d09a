#include "view/saved_views.h"

#include <sys/stat.h>
#include <xxhash.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "core/descriptor.h"
#include "core/error.h"
#include "core/file.h"
#include "ppve/link.h"

namespace view {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostNameBytes = 64;  // of the source's name in the folder's
constexpr mode_t kPrivate = 0700;

std::string state_folder() {
    if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state == '/') return state;
    const char* const home = std::getenv("HOME");
    if (!home || *home != '/')
        throw core::Error("views are not kept: neither XDG_STATE_HOME nor HOME names a folder");
    return std::string(home) + "/.local/state";
}

bool is_address(const std::string& source) {
    return source.find("://") != source.npos || ppve::is_server_address(source);
}

std::string what_it_is(const std::string& source) {
    if (is_address(source)) return source;
    std::error_code failure;
    const fs::path name = fs::weakly_canonical(fs::absolute(source, failure), failure);
    return failure ? source : name.string();
}

// What people know it by, of bytes that no shell minds.
std::string name_of(const std::string& source) {
    std::string name = fs::path(source).filename().string().substr(0, kMostNameBytes);
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '_') c = '-';
    return name;
}

std::string file_of(const std::string& folder, size_t number) {
    return folder + "/" + std::to_string(number + 1) + ".jsonl";
}

void make_private(const fs::path& folder) {
    if (folder.has_parent_path() && folder != folder.root_path()) make_private(folder.parent_path());
    struct stat there {};
    if (::stat(folder.c_str(), &there) == 0) return;  // what is no folder shows when it is written to
    if (::mkdir(folder.c_str(), kPrivate) != 0 && errno != EEXIST)
        core::fail_with_errno(folder.string(), "cannot be made");
}

}  // namespace

std::string views_folder(const std::vector<std::string>& sources) {
    std::string all;
    for (const std::string& source : sources) all += what_it_is(source) + '\n';
    const auto hash = static_cast<unsigned long long>(XXH3_64bits(all.data(), all.size()));
    return state_folder() + "/qs-view/" + name_of(sources.front()) + core::text("-%016llx", hash);
}

std::optional<geom::Camera> read_view(const std::string& folder, size_t number) {
    const std::string name = file_of(folder, number);
    std::error_code unknown;
    if (!fs::exists(name, unknown)) return {};
    const core::InputFile file(name);
    const std::span<const std::byte> bytes = file.bytes();
    const std::vector<geom::Camera> path =
        geom::parse_path({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name);
    if (path.size() > 1)
        throw core::Error(
            core::text("%s: has %zu cameras, and a saved view is one", name.c_str(), path.size()));
    return path.front();
}

std::string write_view(const std::string& folder, size_t number, const geom::Camera& camera) {
    make_private(folder);
    const std::string name = file_of(folder, number);
    core::OutputFile file(name);
    file.write(geom::format_camera(camera));
    file.commit();
    return name;
}

}  // namespace view
