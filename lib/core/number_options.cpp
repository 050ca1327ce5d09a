#include "core/number_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace core {

namespace {

// What messages call the option: its first long name, "--threshold".
std::string shown_name(const std::string& names) {
    for (const std::string& name : CLI::detail::split(names, ','))
        if (name.starts_with("--") || !name.starts_with("-")) return name;
    return names;
}

std::string shortest(double value) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
}

// A finite number that is all of `input`, or nothing.  Independent of the locale.
std::optional<double> parse_double(std::string_view input) {
    if (input.size() > 1 && input[0] == '+' && input[1] != '-') input.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(input.data(), input.data() + input.size(), value);
    if (error != std::errc() || end != input.data() + input.size() || !std::isfinite(value)) return {};
    return value;
}

std::optional<int64_t> parse_integer(std::string_view input) {
    if (input.size() > 1 && input[0] == '+' && input[1] != '-') input.remove_prefix(1);
    int64_t value = 0;
    const auto [end, error] = std::from_chars(input.data(), input.data() + input.size(), value);
    if (error != std::errc() || end != input.data() + input.size()) return {};
    return value;
}

// "; try 1.5" where `input` is a number written with a decimal comma.
std::string hint_for_comma(const std::string& input) {
    std::string with_point = input;
    if (std::count(input.begin(), input.end(), ',') != 1) return "";
    with_point[input.find(',')] = '.';
    return parse_double(with_point) ? "; try " + with_point : "";
}

std::string range_sentence(const std::string& low, const std::string& high, const std::string& unit) {
    const std::string of = unit.empty() ? "" : " " + unit;
    if (high.empty()) return "at least " + low + of;
    if (low.empty()) return "at most " + high + of;
    return "from " + low + " to " + high + of;
}

std::string upper(std::string word) {
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return word;
}

constexpr std::string_view kSizeSuffixes = "KMG";

std::optional<uint64_t> parse_size(std::string_view input) {
    uint64_t value = 0;
    const char* const last = input.data() + input.size();
    const auto [end, error] = std::from_chars(input.data(), last, value);
    if (error != std::errc()) return {};
    if (end == last) return value;
    const char letter = *end >= 'a' ? static_cast<char>(*end - 'a' + 'A') : *end;
    const size_t power = kSizeSuffixes.find(letter);
    if (end + 1 != last || power == std::string_view::npos) return {};
    const unsigned shift = 10 * (static_cast<unsigned>(power) + 1);
    if (value > std::numeric_limits<uint64_t>::max() >> shift) return {};
    return value << shift;
}

// "33ms", "33", "0.033s" or "2m", in milliseconds.
std::optional<double> parse_duration_ms(std::string_view input) {
    constexpr std::pair<std::string_view, double> units[] = {{"ms", 1}, {"s", 1000}, {"m", 60'000}};
    for (const auto& [suffix, ms] : units) {
        if (!input.ends_with(suffix)) continue;
        const std::optional<double> number = parse_double(input.substr(0, input.size() - suffix.size()));
        return number ? std::optional(*number * ms) : std::nullopt;
    }
    return parse_double(input);
}

// "384k", "8M", "1.5G" or "9600", in bits a second; powers of 1000, as rates of links are told.
std::optional<double> parse_rate(std::string_view input) {
    constexpr std::pair<char, double> units[] = {{'k', 1e3}, {'K', 1e3}, {'M', 1e6}, {'G', 1e9}};
    for (const auto& [suffix, factor] : units) {
        if (!input.ends_with(suffix)) continue;
        const std::optional<double> number = parse_double(input.substr(0, input.size() - 1));
        return number ? std::optional(*number * factor) : std::nullopt;
    }
    return parse_double(input);
}

std::string shown_size(uint64_t bytes) {
    std::string suffix;
    for (const char letter : kSizeSuffixes) {
        if (bytes == 0 || bytes % 1024 != 0) break;
        bytes /= 1024;
        suffix = letter;
    }
    return std::to_string(bytes) + suffix;
}

}  // namespace

CLI::Option* add_number(CLI::App& app, const std::string& names, double& value, double low, double high,
                        const std::string& unit, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::string of = unit.empty() ? "" : " of " + unit;
        const std::optional<double> number = parse_double(input);
        if (!number)
            throw UsageError(name + ": '" + input + "' is not a number" + of + hint_for_comma(input));
        if (!(*number >= low && *number <= high)) {
            const std::string range = range_sentence(std::isfinite(low) ? shortest(low) : "",
                                                     std::isfinite(high) ? shortest(high) : "", unit);
            throw UsageError(name + ": " + input + " is out of range; it must be " + range);
        }
        value = *number;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name(unit.empty() ? "NUMBER" : upper(unit))
        ->default_str(std::isfinite(value) ? shortest(value) : "");
}

CLI::Option* add_integer(CLI::App& app, const std::string& names, int64_t& value, int64_t low, int64_t high,
                         const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::optional<int64_t> number = parse_integer(input);
        if (!number) throw UsageError(name + ": '" + input + "' is not a whole number");
        if (*number < low || *number > high) {
            const std::string range =
                range_sentence(low > std::numeric_limits<int64_t>::min() ? std::to_string(low) : "",
                               high < std::numeric_limits<int64_t>::max() ? std::to_string(high) : "", "");
            throw UsageError(name + ": " + input + " is out of range; it must be " + range);
        }
        value = *number;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("N")
        ->default_str(std::to_string(value));
}

CLI::Option* add_size(CLI::App& app, const std::string& names, uint64_t& value, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::optional<uint64_t> size = parse_size(input);
        if (!size)
            throw UsageError(name + ": '" + input + "' is not a size; give bytes, as in 4096, 64K, 8M or 2G");
        value = *size;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("SIZE")
        ->default_str(shown_size(value));
}

CLI::Option* add_duration(CLI::App& app, const std::string& names, double& value_ms, double low_ms,
                          double high_ms, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value_ms](const std::string& input) {
        const std::optional<double> ms = parse_duration_ms(input);
        if (!ms)
            throw UsageError(name + ": '" + input +
                             "' is not a time; give milliseconds, as in 33, 33ms or 0.033s");
        if (!(*ms >= low_ms && *ms <= high_ms))
            throw UsageError(name + ": " + input + " is out of range; it must be " +
                             range_sentence(shortest(low_ms), shortest(high_ms), "ms"));
        value_ms = *ms;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("TIME")
        ->default_str(!std::isfinite(value_ms) ? ""
                      : value_ms == 0          ? "0"
                                               : shortest(value_ms) + "ms");
}

CLI::Option* add_rate(CLI::App& app, const std::string& names, double& bits_per_s, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &bits_per_s](const std::string& input) {
        const std::optional<double> rate = parse_rate(input);
        if (!rate || !(*rate > 0))
            throw UsageError(name + ": '" + input +
                             "' is not a rate; give bits a second, as in 384k, 8M or 1G");
        bits_per_s = *rate;
    };
    return app.add_option_function<std::string>(names, take, help)->type_name("RATE");
}

CLI::Option* add_numbers(CLI::App& app, const std::string& names, std::span<double> values,
                         const std::string& form, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=](const std::string& input) {
        std::vector<double> numbers;
        size_t begin = 0;
        while (begin <= input.size()) {
            const size_t end = std::min(input.find(',', begin), input.size());
            const std::optional<double> number =
                parse_double(std::string_view(input).substr(begin, end - begin));
            if (!number) break;
            numbers.push_back(*number);
            begin = end + 1;
        }
        if (begin <= input.size() || numbers.size() != values.size())
            throw UsageError(name + ": '" + input + "' is not " + form + ", " +
                             std::to_string(values.size()) + " numbers with commas between");
        std::copy(numbers.begin(), numbers.end(), values.begin());
    };
    std::string shown;
    for (const double value : values) shown += (shown.empty() ? "" : ",") + shortest(value);
    const bool has_default =
        std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    return app.add_option_function<std::string>(names, take, help)
        ->type_name(form)
        ->default_str(has_default ? shown : "");
}

}  // namespace core
