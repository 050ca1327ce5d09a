#include "mesh/text.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>

#include "core/error.h"

namespace mesh {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

std::string_view without_plus(std::string_view word) {
    return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

}  // namespace

TextReader::TextReader(const Source& source, size_t at, char comment)
    : source_(source), text_(source.text()), at_(at), last_word_(at), comment_(comment) {}

void TextReader::skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    if (comment_ != 0 && at_ < text_.size() && text_[at_] == comment_)
        while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
}

std::string_view TextReader::word_in_line() {
    skip_blanks();
    const size_t begin = at_;
    while (at_ < text_.size() && !is_blank(text_[at_]) && !is_line_end(text_[at_])) ++at_;
    if (at_ > begin) last_word_ = begin;
    return text_.substr(begin, at_ - begin);
}

std::string_view TextReader::word() {
    for (;;) {
        const std::string_view found = word_in_line();
        if (!found.empty() || !next_line()) return found;
    }
}

bool TextReader::next_line() {
    while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
    if (at_ == text_.size()) return false;
    if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
    ++at_;
    return true;
}

double TextReader::number(std::string_view word) const {
    const std::string_view digits = without_plus(word);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end == digits.data() + digits.size()) {
        if (error == std::errc()) return value;
        // from_chars does not say whether the number is too large or too small.
        if (error == std::errc::result_out_of_range) return std::strtod(std::string(digits).c_str(), nullptr);
    }
    if (digits.find(".#") != std::string_view::npos) return std::numeric_limits<double>::quiet_NaN();
    fail(quoted(word) + " is not a number");
}

int64_t TextReader::integer(std::string_view word) const {
    const std::string_view digits = without_plus(word);
    int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size())
        fail(quoted(word) + " is not a whole number");
    return value;
}

void TextReader::fail(const std::string& what) const {
    const std::string_view before = text_.substr(0, last_word_);
    auto lines = std::count(before.begin(), before.end(), '\n');
    if (lines == 0) lines = std::count(before.begin(), before.end(), '\r');
    throw core::Error(core::text("%s: line %td: %s", source_.name.c_str(), lines + 1, what.c_str()));
}

}  // namespace mesh
