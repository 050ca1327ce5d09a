// Options that take one of a few words: checked in one place, listed in messages, completed by shells.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace core {

// For CLI::Option::check().  Another word is refused: "--shade: 'shiny' is not lit, normal, level or flat".
// No word is empty or has a '|' in it; there is one at least.
CLI::Validator one_of(const std::vector<std::string>& words);

// The words that one_of() lets pass; empty where the option has no such check.
std::vector<std::string> words_of(CLI::Option& option);

}  // namespace core
