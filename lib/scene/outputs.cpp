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
            throw UsageError(file + ": would be written twice; name the outputs apart");
    }

    void add_frames(const std::string& name, bool holds_one, size_t frame_count) {
        if (name.empty()) return;
        const bool is_numbered = render::has_frame_number(name);
        if (holds_one && frame_count > 1 && !is_numbered && name != "-")
            throw UsageError(core::text("%s: one file for %zu frames; number them with %%04d in the name",
                                        name.c_str(), frame_count));
        for (size_t i = 0; i < (is_numbered ? frame_count : 1); ++i) add(render::frame_name(name, int(i)));
    }

  private:
    std::span<const std::string> inputs_;
    std::unordered_set<std::string> written_;
};

}  // namespace

void check(const Outputs& outputs, std::span<const std::string> inputs, size_t frame_count) {
    Check check(inputs);
    check.add_frames(outputs.pictures, outputs.format == render::ImageFormat::png, frame_count);
    check.add_frames(outputs.depths, true, frame_count);
    if (!outputs.report.empty()) check.add(outputs.report);
}

}  // namespace scene
