#include "core/error.h"
#include "ppve/link.h"
#include "scene/progressive.h"
#include "view/subject.h"

namespace view {

std::unique_ptr<Subject> open_subject(const std::vector<std::string>& names, const SubjectOptions& options) {
    const auto is_points = [](const std::string& name) {
        return ppve::is_server_address(name) || ppve::is_session_file(name);
    };
    for (const std::string& name : names) {
        if (!is_points(name) && !scene::is_progressive(name)) continue;
        if (names.size() > 1)
            throw core::UsageError(name + ": a progressive mesh and a server's points are looked at alone");
        return is_points(name) ? open_points(name, options) : open_progressive_mesh(name, options);
    }
    return open_splats(scene::parse_sources(names), options);
}

}  // namespace view
