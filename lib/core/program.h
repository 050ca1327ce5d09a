// What all programs share: common options, checked numbers, exit codes, one-line messages,
// progress, and the last flush of standard output.  Nothing else in the project prints or exits.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "core/messages.h"
#include "core/number_options.h"
#include "core/report.h"

namespace core {

// One program.  Owns --threads, --quiet, --verbose, --progress, --report, --version, --help,
// and --completion, which --help does not show.
//
//     core::Program program("qs-info", "Say what a splat model holds.");
//     program.options.add_flag("--json", json, "...");
//     return program.run(argc, argv, [&] { ... });
//
// run() parses, calls the job, and returns the exit status: 0 done, 1 for core::Error (and for
// std::bad_alloc and other exceptions, with their text) and after fail(), 2 for core::UsageError
// and what the parser refuses.  A closed pipe ends the job quietly, as if it were done.
// --version prints "qs-info 0.1.0".  Messages are "qs-info: sentence\n".
//
// Operands and plain options are added to `options` (CLI11): add_option("MODEL", path, "...") ->
// required().  Defaults are shown by --help without asking; the last of repeated options counts;
// a value may start with '-'.  Subcommands inherit all that, and the common options.
class Program {
  public:
    Program(std::string name, std::string description, std::string version);

    CLI::App options;

    int run(int argc, char** argv, const std::function<void()>& job);

    // Numbers with a range, refusing nan, trailing text, and "-5" for a size; --help shows the
    // default, messages name the option.  `unit` is for the message ("pixels", "degrees").
    // A bound or default that is not finite means "none".  Nothing is written to `value` unless the
    // option is given and right.  For a subcommand's options, call those of number_options.h.
    CLI::Option* add_number(const std::string& names, double& value, double low, double high,
                            const std::string& unit, const std::string& help);
    CLI::Option* add_integer(const std::string& names, int64_t& value, int64_t low, int64_t high,
                             const std::string& help);
    // Bytes: 4096, 64K, 8M, 2G (powers of 1024).
    CLI::Option* add_size(const std::string& names, uint64_t& value, const std::string& help);
    // Times: 33ms, 0.033s, 2m; a plain number is milliseconds.  The value is in milliseconds.
    CLI::Option* add_duration(const std::string& names, double& value_ms, double low_ms, double high_ms,
                              const std::string& help);
    // As many finite numbers as `values` has, with commas between: --camera-position -1,0,2.5.
    // `form` is how --help and messages write it ("X,Y,Z").
    CLI::Option* add_numbers(const std::string& names, std::span<double> values, const std::string& form,
                             const std::string& help);

    const std::string& name() const { return name_; }

  private:
    std::string name_, version_;
};

}  // namespace core
