// Options whose value is one of a few words: checked in one place, listed in messages, completed by shells.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "core/error.h"

namespace core {

template <class T>
struct Word {
    const char* word;
    T value;
};

// "a, b or c".
std::string one_among(const std::vector<std::string>& words);

// "'x' is not a, b or c"; there is one word at least.
std::string is_not(const std::string& word, const std::vector<std::string>& words);

// The word that somebody who wrote `word` is likely to have meant: the first of those that begin with it, or
// else of those that are fewest changes of a letter away, at most 2.  Empty where there is none.
std::string likely_word(const std::string& word, const std::vector<std::string>& words);

// For CLI::Option::check().  Another word is refused: "--shade: 'shiny' is not lit, normal, level or flat".
// No word is empty or has a '|' in it; there is one at least.
CLI::Validator one_of(const std::vector<std::string>& words);

// The words that one_of() lets pass; empty where the option has no such check.
std::vector<std::string> words_of(CLI::Option& option);

template <class T, size_t N>
std::vector<std::string> names_of(const Word<T> (&words)[N]) {
    std::vector<std::string> names;
    for (const Word<T>& word : words) names.push_back(word.word);
    return names;
}

template <class T, size_t N>
CLI::Validator one_of(const Word<T> (&words)[N]) {
    return one_of(names_of(words));
}

// Throws UsageError "<option>: 'x' is not a, b or c".
template <class T, size_t N>
T value_of(const std::string& option, const std::string& word, const Word<T> (&words)[N]) {
    for (const Word<T>& known : words)
        if (word == known.word) return known.value;
    throw UsageError(option + ": " + is_not(word, names_of(words)));
}

}  // namespace core
