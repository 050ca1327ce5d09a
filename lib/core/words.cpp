#include "core/words.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace core {

namespace {

constexpr char kBetween = '|';

// Letters to be added, left out or replaced until `a` is `b` (Levenshtein).
size_t changes_between(const std::string& a, const std::string& b) {
    std::vector<size_t> changes(b.size() + 1);  // from the part of `a` so far to each beginning of `b`
    std::iota(changes.begin(), changes.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = std::exchange(changes[0], i + 1);
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal =
                std::exchange(changes[j + 1], std::min({replaced, changes[j] + 1, changes[j + 1] + 1}));
        }
    }
    return changes.back();
}

}  // namespace

std::string one_among(const std::vector<std::string>& words) {
    std::string list;
    for (size_t i = 0; i < words.size(); ++i)
        list += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    return list;
}

std::string is_not(const std::string& word, const std::vector<std::string>& words) {
    return "'" + word + "' is not " + one_among(words);
}

std::string likely_word(const std::string& word, const std::vector<std::string>& words) {
    constexpr size_t kMostChanges = 2;
    std::string likely;
    size_t fewest = kMostChanges + 1;
    for (const std::string& known : words) {
        if (known.starts_with(word)) return known;
        const size_t changes = changes_between(word, known);
        if (changes < fewest) fewest = changes, likely = known;
    }
    return likely;
}

CLI::Validator one_of(const std::vector<std::string>& words) {
    const auto check = [words](const std::string& word) {
        const bool is_known = std::find(words.begin(), words.end(), word) != words.end();
        return is_known ? "" : is_not(word, words);
    };
    // An option keeps no more of its check than a name and a description, and --help would show the
    // description.
    return {check, "", CLI::detail::join(words, std::string(1, kBetween))};
}

std::vector<std::string> words_of(CLI::Option& option) {
    for (int i = 0;; ++i) {
        const CLI::Validator* validator = nullptr;
        try {
            validator = option.get_validator(i);
        } catch (const CLI::OptionNotFound&) {
            return {};  // all have been looked at
        }
        if (!validator->get_name().empty()) return CLI::detail::split(validator->get_name(), kBetween);
    }
}

}  // namespace core
