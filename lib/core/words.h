// Options whose value is one of a few words.
#pragma once

#include <cstddef>
#include <string>

#include "core/error.h"

namespace core {

template <class T>
struct Word {
    const char* word;
    T value;
};

// Throws UsageError "<option>: 'x' is not a, b or c".
template <class T, size_t N>
T value_of(const std::string& option, const std::string& word, const Word<T> (&words)[N]) {
    std::string list;
    for (size_t i = 0; i < N; ++i) {
        if (word == words[i].word) return words[i].value;
        list += (i == 0 ? "" : i + 1 == N ? " or " : ", ") + std::string(words[i].word);
    }
    throw UsageError(option + ": '" + word + "' is not " + list);
}

}  // namespace core
