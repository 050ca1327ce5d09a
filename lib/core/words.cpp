#include "core/words.h"

#include <algorithm>

namespace core {

namespace {

constexpr char kBetween = '|';

}  // namespace

std::string is_not(const std::string& word, const std::vector<std::string>& words) {
    std::string list;
    for (size_t i = 0; i < words.size(); ++i)
        list += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    return "'" + word + "' is not " + list;
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
