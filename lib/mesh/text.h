// Words and numbers of a text format, with the line they stand in for messages.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"
#include "mesh/reader.h"

namespace mesh {

// Walks over a text.  Lines end with \n, \r\n or \r; blanks, tabs, vertical tabs and form feeds
// part words.  Errors are thrown as "file: line N: what".
class TextReader {
  public:
    // Begins at byte `at`.  `comment`: the character that makes the rest of a line a comment, or 0.
    TextReader(const Source& source, size_t at, char comment);

    // The next word on this line or a later one; empty at the end of the text.
    std::string_view word();
    // The next word on this line; empty at its end.
    std::string_view word_in_line();
    // To the beginning of the next line; false at the end of the text.
    bool next_line();

    size_t position() const { return at_; }  // bytes from the beginning of the source
    size_t bytes_left() const { return text_.size() - at_; }

    // Decimal, in any notation from_chars takes, also with '+'; "inf", "nan" and MSVC's "1.#INF" too.
    double number(std::string_view word) const;
    int64_t integer(std::string_view word) const;

    // Three numbers: the word `first` and two that next() gives, which is empty where the line ends.
    // `what` they are, in the plural, is for the message.
    template <class NextWord>
    glm::dvec3 three(std::string_view first, const NextWord& next, const char* what) const {
        glm::dvec3 numbers;
        for (int k = 0; k < 3; ++k) {
            const std::string_view word = k == 0 ? first : next();
            if (word.empty()) fail(core::text("expected 3 %s, found %d", what, k));
            numbers[k] = number(word);
        }
        return numbers;
    }
    // Three coordinates, which with_bad allows not to be finite.
    template <class NextWord>
    glm::dvec3 point(std::string_view first, const NextWord& next, bool with_bad) const {
        const glm::dvec3 p = three(first, next, "coordinates");
        if (!with_bad && !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)))
            fail("coordinate is not finite (qs-build and pm-build drop it with --skip-bad)");
        return p;
    }

    // Throws; N is the line of the last word taken.
    [[noreturn]] void fail(const std::string& what) const;

  private:
    bool is_line_end(char c) const { return c == '\n' || c == '\r'; }
    void skip_blanks();

    const Source& source_;
    std::string_view text_;
    size_t at_;
    size_t last_word_;  // where the last word began
    char comment_;
};

}  // namespace mesh
