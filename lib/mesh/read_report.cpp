#include "mesh/read_report.h"

#include "core/error.h"
#include "core/messages.h"

namespace mesh {

namespace {

core::Json to_json(const Drops& drops) {
    core::Json json = core::Json::object();
    for (const auto& [reason, count] : drops) json[reason] = count;
    return json;
}

}  // namespace

core::Json report_of(const std::string& input, const ReadCounts& read, const Drops& vertices_dropped) {
    core::Json json;
    json["input"] = input;
    json["format"] = read.format;
    json["vertices_in"] = read.vertices_in;
    json["faces_in"] = read.faces_in;
    json["triangles_in"] = read.triangles_in;
    json["vertices_dropped"] = to_json(vertices_dropped);
    json["triangles_dropped"] = to_json(read.triangles_dropped);
    return json;
}

void warn_of_drops(const std::string& input, const Drops& drops, const char* what) {
    for (const auto& [reason, count] : drops)
        core::warn(core::text("%s: %llu %s dropped: %s", input.c_str(),
                              static_cast<unsigned long long>(count), what, reason.c_str()));
}

}  // namespace mesh
