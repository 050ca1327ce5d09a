// The JSON of reports and of --json.
#pragma once

#include <nlohmann/json.hpp>

namespace core {

using Json = nlohmann::ordered_json;  // keys in the order they were written

}  // namespace core
