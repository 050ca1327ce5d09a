// What command lines say about how models are drawn, the same in all programs that draw them.
//
// All functions with an option's name throw core::UsageError, which names it and what it could have been.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "render/frame.h"
#include "scene/backends.h"

namespace scene {

// For CLI::Option::check(): the words that the functions below take.
CLI::Validator splat_kinds();
CLI::Validator shades();
CLI::Validator backend_kinds();

render::SplatKind splat_kind_of(const std::string& option, const std::string& word);
render::Shade shade_of(const std::string& option, const std::string& word);
BackendKind backend_kind_of(const std::string& option, const std::string& word);

// "R,G,B", "#rrggbb", "#rrggbbaa" or "none"; alpha is last.
glm::u8vec4 colour_of(const std::string& option, const std::string& word);

// A direction of any length, as Look::key_light: none where its first coordinate was not given (NaN).
std::optional<glm::dvec3> key_light_of(const std::string& option, const std::array<double, 3>& numbers);

}  // namespace scene
