// What was read, as the reports and warnings of all builders have it.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/json.h"
#include "mesh/mesh.h"

namespace mesh {

using Drops = std::map<std::string, uint64_t>;  // how many, by reason

// The first keys of a report: input, format, what came in and what was dropped.  `vertices_dropped`: by the
// reader and the builder together.
core::Json report_of(const std::string& input, const ReadCounts& read, const Drops& vertices_dropped);

// Warns "<input>: 3 vertices dropped: not_finite", a line a reason.  `what`: "vertices" or "triangles".
void warn_of_drops(const std::string& input, const Drops& drops, const char* what);

}  // namespace mesh
