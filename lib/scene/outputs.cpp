#include "scene/outputs.h"

#include <unordered_set>

#include "core/error.h"
#include "core/file.h"

namespace scene {
namespace {

using core::UsageError;

class Check {
  public:
    explicit Check(std::span<const std::string> inputs) : inputs_(inputs) {}

    void add(const std::string& file) {
        for (const std::string& input : inputs_)
            if (core::same_file(input, file)) throw UsageError(file + ": is input and output");
        const std::string lost = core::overwritten_file(file);
        if (!lost.empty() && !written_.insert(lost).second)
            throw UsageError((file == "-" ? "standard output" : file) +
                             ": would be written twice; name the outputs apart");
    }

    void add_frames(const std::string& name, bool holds_one, const DrawnFrames& frames) {
        if (name.empty()) return;
        const bool is_numbered = render::has_frame_number(name), has_eye = render::has_eye(name);
        const size_t count = frames.numbers.size();
        if (holds_one && count > 1 && !is_numbered && name != "-")
            throw UsageError(core::text("%s: one file for %zu frames; number them with %%04d in the name",
                                        name.c_str(), count));
        for (const int number : frames.numbers.first(is_numbered ? count : 1)) {
            add(render::frame_name(name, number, "left"));
            if (frames.is_stereo && has_eye) add(render::frame_name(name, number, "right"));
        }
    }

  private:
    std::span<const std::string> inputs_;
    std::unordered_set<std::string> written_;
};

}  // namespace

void check(const Outputs& outputs, std::span<const std::string> inputs, const DrawnFrames& frames) {
    Check check(inputs);
    check.add_frames(outputs.pictures, outputs.format == render::ImageFormat::png, frames);
    check.add_frames(outputs.depths, true, frames);
    if (!outputs.report.empty()) check.add(outputs.report);
}

}  // namespace scene
