// Options whose values are numbers: checked, with ranges and units, and refused in one sentence.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <span>
#include <string>

namespace core {

// As those of Program (program.h), for any CLI::App below its `options`.
CLI::Option* add_number(CLI::App& app, const std::string& names, double& value, double low, double high,
                        const std::string& unit, const std::string& help);
CLI::Option* add_integer(CLI::App& app, const std::string& names, int64_t& value, int64_t low, int64_t high,
                         const std::string& help);
CLI::Option* add_size(CLI::App& app, const std::string& names, uint64_t& value, const std::string& help);
CLI::Option* add_duration(CLI::App& app, const std::string& names, double& value_ms, double low_ms,
                          double high_ms, const std::string& help);
CLI::Option* add_numbers(CLI::App& app, const std::string& names, std::span<double> values,
                         const std::string& form, const std::string& help);
// Bits a second: 9600, 384k, 8M, 1G (powers of 1000), above 0.  No default is shown.
CLI::Option* add_rate(CLI::App& app, const std::string& names, double& bits_per_s, const std::string& help);

}  // namespace core
