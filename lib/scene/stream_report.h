// The part of a frame's report that is about what arrives, as frame-report(5) has it.
#pragma once

#include "core/json.h"
#include "scene/stream.h"

namespace scene {

core::Json to_json(const StreamReport& report);

}  // namespace scene
