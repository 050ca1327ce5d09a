#include "qs-render/parts.h"

#include <charconv>
#include <limits>
#include <optional>

#include "core/error.h"

namespace qs_render {

using core::text;
using core::UsageError;

namespace {

constexpr int kMostFrames = std::numeric_limits<int>::max();

// Reads whole numbers with single characters between.
class Words {
  public:
    explicit Words(const std::string& word) : at_(word.data()), end_(at_ + word.size()) {}

    std::optional<int> number() {
        int value = 0;
        const auto [rest, error] = std::from_chars(at_, end_, value);
        if (error != std::errc() || *at_ == '-') return std::nullopt;
        at_ = rest;
        return value;
    }
    bool take(char c) {
        const bool is_here = at_ < end_ && *at_ == c;
        at_ += is_here;
        return is_here;
    }
    bool is_at_end() const { return at_ == end_; }

  private:
    const char *at_, *end_;
};

}  // namespace

FrameRange parse_frames(const std::string& word) {
    Words words(word);
    const std::optional<int> begin = words.number();
    bool is_right = words.take(':');
    const std::optional<int> end = words.number();
    std::optional<int> step = 1;
    if (words.take(':')) step = words.number();
    is_right = is_right && words.is_at_end() && step && *step > 0;
    if (!is_right)
        throw UsageError("--frames: '" + word +
                         "' is not A:B or A:B:STEP, whole numbers, of which A and B may be left out");
    const FrameRange range{size_t(begin.value_or(0)), size_t(end.value_or(kMostFrames)), size_t(*step)};
    if (range.begin >= range.end) throw UsageError("--frames: '" + word + "' is no frame");
    return range;
}

std::vector<int> frame_numbers(const FrameRange& range, size_t count) {
    std::vector<int> numbers;
    for (size_t i = range.begin; i < std::min(range.end, count); i += range.step) numbers.push_back(int(i));
    if (numbers.empty())
        throw UsageError(
            text("--frames: the first is %zu, and the path ends with frame %zu", range.begin, count - 1));
    return numbers;
}

scene::Tile parse_tile(const std::string& word) {
    Words words(word);
    const std::optional<int> x = words.number();
    bool is_right = words.take(',');
    const std::optional<int> y = words.number();
    is_right = is_right && words.take('/');
    const std::optional<int> across = words.number();
    is_right = is_right && words.take(',');
    const std::optional<int> down = words.number();
    if (!is_right || !words.is_at_end() || !x || !y || !across || !down)
        throw UsageError("--tile: '" + word + "' is not X,Y/NX,NY in whole numbers");
    if (*x >= *across || *y >= *down)
        throw UsageError(
            text("--tile: there is no tile %d,%d of %d x %d; they count from 0", *x, *y, *across, *down));
    return {*x, *y, *across, *down};
}

}  // namespace qs_render
