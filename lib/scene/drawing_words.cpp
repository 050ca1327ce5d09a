#include "scene/drawing_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/words.h"

namespace scene {

namespace {

using core::Word;

constexpr Word<render::SplatKind> kSplatWords[] = {{"square", render::SplatKind::square},
                                                   {"circle", render::SplatKind::circle},
                                                   {"ellipse", render::SplatKind::ellipse},
                                                   {"smooth", render::SplatKind::smooth}};
constexpr Word<render::Shade> kShadeWords[] = {{"lit", render::Shade::lit},
                                               {"normal", render::Shade::normal},
                                               {"level", render::Shade::level},
                                               {"flat", render::Shade::flat}};
constexpr Word<BackendKind> kBackendWords[] = {{"cpu", BackendKind::cpu},
                                               {"osmesa", BackendKind::osmesa},
                                               {"egl", BackendKind::egl},
                                               {"auto", BackendKind::automatic}};

}  // namespace

CLI::Validator splat_kinds() {
    return core::one_of(kSplatWords);
}
CLI::Validator shades() {
    return core::one_of(kShadeWords);
}
CLI::Validator backend_kinds() {
    return core::one_of(kBackendWords);
}

render::SplatKind splat_kind_of(const std::string& option, const std::string& word) {
    return core::value_of(option, word, kSplatWords);
}

render::Shade shade_of(const std::string& option, const std::string& word) {
    return core::value_of(option, word, kShadeWords);
}

BackendKind backend_kind_of(const std::string& option, const std::string& word) {
    return core::value_of(option, word, kBackendWords);
}

glm::u8vec4 colour_of(const std::string& option, const std::string& word) {
    if (word == "none") return glm::u8vec4(0);
    const bool is_hex = word.starts_with('#');
    glm::u8vec4 colour(0, 0, 0, 255);
    const char* at = word.data();
    const char* const end = at + word.size();
    bool is_right = !is_hex || word.size() == 7 || word.size() == 9;
    for (int k = 0; k < (word.size() == 9 && is_hex ? 4 : 3) && is_right; ++k) {
        if (is_hex ? k == 0 : k > 0) is_right = at < end && *at++ == (is_hex ? '#' : ',');
        const char* const last = is_hex ? at + 2 : end;
        uint8_t value = 0;
        const auto [rest, error] = std::from_chars(at, last, value, is_hex ? 16 : 10);
        is_right = is_right && error == std::errc() && (!is_hex || rest == last);
        colour[k] = value;
        at = rest;
    }
    if (!is_right || at != end)
        throw core::UsageError(option + ": '" + word +
                               "' is not R,G,B with numbers from 0 to 255, #rrggbb, #rrggbbaa or none");
    return colour;
}

std::optional<glm::dvec3> key_light_of(const std::string& option, const std::array<double, 3>& numbers) {
    if (std::isnan(numbers[0])) return {};
    const glm::dvec3 light{numbers[0], numbers[1], numbers[2]};
    const double size = std::max({std::fabs(light.x), std::fabs(light.y), std::fabs(light.z)});
    if (size == 0) throw core::UsageError(option + ": 0,0,0 is no direction");
    return light / size;  // its square is in range
}

}  // namespace scene
