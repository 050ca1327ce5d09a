#include "fetch/header_rules.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "fetch/descriptor.h"
#include "fetch/transport.h"

namespace fetch {

namespace {

constexpr size_t kMostFileBytes = 64 * 1024;
// Those that say which bytes of which version come are qs-fetch's own.
constexpr const char* kOwnFields[] = {"range", "accept-encoding", "connection", "host", "transfer-encoding"};

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = char(c + ('a' - 'A'));
    return out;
}

std::string read_private_file(const std::string& path) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) fail_with_errno(path, "cannot open");
    struct stat status = {};
    if (::fstat(file.get(), &status) != 0) fail_with_errno(path, "cannot look at the file");
    if (status.st_uid != ::geteuid())
        throw core::Error(core::text("%s: belongs to user %u, not to %u", path.c_str(),
                                     unsigned(status.st_uid), unsigned(::geteuid())));
    if (status.st_mode & 077)
        throw core::Error(core::text("%s: is open to others (mode %03o); close it by 'chmod 600'",
                                     path.c_str(), unsigned(status.st_mode & 0777)));
    std::string text(kMostFileBytes + 1, '\0');
    size_t size = 0;
    while (size < text.size()) {
        const ssize_t got = ::read(file.get(), text.data() + size, text.size() - size);
        if (got < 0) fail_with_errno(path, "cannot read");
        if (got == 0) break;
        size += size_t(got);
    }
    if (size > kMostFileBytes) throw core::Error(path + ": is longer than 64 KiB");
    text.resize(size);
    return text;
}

std::string_view trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

// Why a field cannot be sent; empty where it can.
std::string fault_of(std::string_view field) {
    const size_t colon = field.find(':');
    const std::string_view name = field.substr(0, colon);
    const bool is_name =
        colon != std::string_view::npos && !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
            return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
                   c == '_';
        });
    if (!is_name) return "expected a URL and a field, as in 'https://host/ Authorization: Bearer 123'";
    if (trimmed(field.substr(colon + 1)).empty()) return "the field has no value";
    if (!std::all_of(field.begin(), field.end(), [](char c) { return (c >= ' ' && c <= '~') || c == '\t'; }))
        return "the field holds characters other than printable ASCII";
    const std::string own = lower(name);
    if (own.starts_with("if-") ||
        std::find(std::begin(kOwnFields), std::end(kOwnFields), own) != std::end(kOwnFields))
        return core::text("'%.*s' is set by qs-fetch itself", int(name.size()), name.data());
    return "";
}

}  // namespace

HeaderRules::HeaderRules(const std::string& path) {
    const std::string text = read_private_file(path);
    size_t number = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = trimmed(std::string_view(text).substr(at, end - at));
        at = end + 1;
        ++number;
        if (line.empty() || line.front() == '#') continue;
        const auto fail = [&](const std::string& why) {
            throw core::Error(core::text("%s: line %zu: ", path.c_str(), number) + why);
        };
        const size_t blank = std::min(line.find_first_of(" \t"), line.size());
        const std::string prefix(line.substr(0, blank));
        const std::string_view field = trimmed(line.substr(blank));
        try {
            server_of(prefix);
        } catch (const core::Error& error) {
            fail(error.what());
        }
        // Up to a "/", or a host whose name only begins alike would be sent what is not for it.
        if (!prefix.ends_with('/') || std::count(prefix.begin(), prefix.end(), '/') < 3)
            fail("the URL does not end with '/'");
        if (const std::string fault = fault_of(field); !fault.empty()) fail(fault);
        rules_.push_back({prefix, std::string(field)});
    }
}

std::vector<std::string> HeaderRules::fields_for(const std::string& url) const {
    std::vector<std::string> fields;
    for (const Rule& rule : rules_)
        if (url.starts_with(rule.prefix)) fields.push_back(rule.field);
    return fields;
}

std::string default_header_rules() {
    const char* const config = std::getenv("XDG_CONFIG_HOME");
    const char* const home = std::getenv("HOME");
    std::string path;
    if (config && *config == '/')
        path = std::string(config) + "/qs-fetch/headers";
    else if (home && *home == '/')
        path = std::string(home) + "/.config/qs-fetch/headers";
    return !path.empty() && ::access(path.c_str(), F_OK) == 0 ? path : "";
}

}  // namespace fetch
