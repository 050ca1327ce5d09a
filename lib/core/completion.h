// Completion of a program's command line in interactive shells, written from the table of its options: what
// --help lists is what is completed.
//
// After an option that takes one_of() some words come these, after one that takes a file or a folder the
// names of files or folders, after one that takes a number nothing; subcommands have their own options and
// those of the program.  What an option takes is told by its type name, as --help shows it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace core {

// The group of the option that asks for a script, which is neither completed nor in --help.
constexpr const char* kCompletionGroup = "Completion";

// What it takes: bash, zsh, fish.
const std::vector<std::string>& completion_shells();

// The script that `shell`, one of the above, loads for `program`, whose options and subcommands `options`
// has.
std::string completion_script(CLI::App& options, const std::string& program, const std::string& shell);

}  // namespace core
