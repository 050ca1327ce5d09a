#include <charconv>
#include <cmath>
#include <functional>
#include <map>

#include "core/error.h"
#include "qs-render/points.h"

namespace qs_render {

using core::text;
using core::UsageError;

namespace {

double number(const std::string& key, std::string_view word, double low, double high) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !(value >= low && value <= high))
        throw UsageError(text("--ppve: %s=%.*s: expected a number from %g to %g", key.c_str(),
                              int(word.size()), word.data(), low, high));
    return value;
}

// 4096, 64K, 8M, 2G.
uint64_t size(const std::string& key, std::string_view word, double low) {
    double factor = 1;
    const size_t unit = word.empty() ? std::string_view::npos : std::string_view("KMG").find(word.back());
    if (unit != std::string_view::npos) {
        factor = std::ldexp(1, 10 * int(unit + 1));
        word.remove_suffix(1);
    }
    return static_cast<uint64_t>(number(key, word, low / factor, 0x1p50 / factor) * factor);
}

std::pair<std::string_view, std::string_view> halves(const std::string& key, std::string_view word,
                                                     char between, const char* form) {
    const size_t at = word.find(between);
    if (at == word.npos)
        throw UsageError(
            text("--ppve: %s=%.*s: expected %s", key.c_str(), int(word.size()), word.data(), form));
    return {word.substr(0, at), word.substr(at + 1)};
}

template <class T>
T choice(const std::string& key, std::string_view word,
         std::initializer_list<std::pair<const char*, T>> choices) {
    std::string names;
    for (const auto& [name, value] : choices) {
        if (word == name) return value;
        names += (names.empty() ? "" : " or ") + std::string(name);
    }
    throw UsageError(
        text("--ppve: %s=%.*s: expected %s", key.c_str(), int(word.size()), word.data(), names.c_str()));
}

using Word = std::string_view;
using Setter = std::function<void(PointSettings&, const std::string& key, Word value)>;

const std::map<std::string, Setter>& flags() {
    static const std::map<std::string, Setter> all{
        {"realtime", [](PointSettings& s, auto&, Word) { s.is_realtime = true; }},
        {"closed", [](PointSettings& s, auto&, Word) { s.is_closed = true; }},
    };
    return all;
}

const std::map<std::string, Setter>& values() {
    static const std::map<std::string, Setter> all{
        {"size",
         [](PointSettings& s, auto& key, Word value) {
             const auto [width, height] = halves(key, value, 'x', "WIDTHxHEIGHT");
             s.client.width = int(number(key, width, 1, 16384));
             s.client.height = int(number(key, height, 1, 16384));
         }},
        {"scale", [](PointSettings& s, auto& key, Word v) { s.scale = number(key, v, 0.1, 16); }},
        {"rule",
         [](PointSettings& s, auto& key, Word value) {
             const auto [ratio, epsilon] = halves(key, value, ':', "RATIO:EPSILON");
             s.rule = {number(key, ratio, 1, 1000), number(key, epsilon, 0, 1)};
         }},
        {"velocity", [](PointSettings& s, auto& key, Word v) { s.velocity_px = number(key, v, 0, 1e6); }},
        {"points", [](PointSettings& s, auto& key, Word v) { s.most_points = size(key, v, 1000); }},
        {"memory", [](PointSettings& s, auto& key, Word v) { s.client.most_bytes = size(key, v, 1 << 20); }},
        {"keep", [](PointSettings& s, auto& key, Word v) { s.client.keep_s = number(key, v, 0.1, 1e9); }},
        {"bound", [](PointSettings& s, auto& key, Word v) { s.client.bound_px = number(key, v, 0, 16); }},
        {"timeout",
         [](PointSettings& s, auto& key, Word v) { s.client.answer_timeout_s = number(key, v, 0.1, 1e6); }},
        {"epsilon", [](PointSettings& s, auto& key, Word v) { s.client.epsilon = number(key, v, 0, 1e150); }},
        {"eliminate",
         [](PointSettings& s, auto& key, Word v) {
             using ppve::Elimination;
             s.client.elimination = choice<Elimination>(key, v,
                                                        {{"filtered", Elimination::filtered},
                                                         {"paper", Elimination::paper},
                                                         {"none", Elimination::none}});
         }},
        {"codec",
         [](PointSettings& s, auto& key, Word v) {
             s.client.codec =
                 choice<ppve::Codec>(key, v, {{"planes", ppve::Codec::planes}, {"lzw", ppve::Codec::lzw}});
         }},
        {"predict",
         [](PointSettings& s, auto& key, Word v) {
             s.client.predicts = choice<bool>(key, v, {{"on", true}, {"off", false}});
         }},
        {"light",
         [](PointSettings& s, auto& key, Word v) {
             s.is_lit_by_server = choice<bool>(key, v, {{"client", false}, {"server", true}});
         }},
        {"record", [](PointSettings& s, auto&, Word v) { s.record = v; }},
    };
    return all;
}

void set(PointSettings& settings, std::string_view word) {
    const size_t at = word.find('=');
    const std::string key(word.substr(0, at));
    const auto& known = at == word.npos ? flags() : values();
    const auto found = known.find(key);
    if (found == known.end())
        throw UsageError("--ppve: '" + std::string(word) +
                         "' is no setting; they are in qs-render(1), REMOTE POINTS");
    found->second(settings, key, at == word.npos ? Word() : word.substr(at + 1));
}

}  // namespace

PointSettings parse_point_settings(const std::string& words) {
    PointSettings settings;
    std::string_view rest = words;
    while (!rest.empty()) {
        const size_t at = rest.find(',');
        set(settings, rest.substr(0, at));
        rest = at == rest.npos ? std::string_view() : rest.substr(at + 1);
    }
    return settings;
}

}  // namespace qs_render
