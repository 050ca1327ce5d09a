// What command lines say about how models are drawn, the same in all programs that draw them.
//
// All throw core::UsageError, which names the option and what it could have been.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "render/frame.h"
#include "scene/backends.h"

namespace scene {

render::SplatKind splat_kind_of(const std::string& option, const std::string& word);
render::Shade shade_of(const std::string& option, const std::string& word);
BackendKind backend_kind_of(const std::string& option, const std::string& word);

// "R,G,B", "#rrggbb", "#rrggbbaa" or "none"; alpha is last.
glm::u8vec4 colour_of(const std::string& option, const std::string& word);

// A direction of any length, as Look::key_light: none where its first coordinate was not given (NaN).
std::optional<glm::dvec3> key_light_of(const std::string& option, const std::array<double, 3>& numbers);

}  // namespace scene
