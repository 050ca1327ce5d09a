#include "core/report.h"

#include "core/error.h"
#include "core/file.h"
#include "core/settings.h"

namespace core {

struct Report::State {
    explicit State(const std::string& path) : file(path) {}
    OutputFile file;
};

Report::Report(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
    for (const std::string& input : inputs)
        if (same_file(input, settings.report))
            throw UsageError("--report: " + settings.report + " is what the job reads");
    const std::string file = overwritten_file(settings.report);
    const auto is_report = [&](const std::string& output) {
        if (output == "-" && settings.report == "-") return true;
        return !file.empty() && overwritten_file(output) == file;
    };
    for (const std::string& output : outputs)
        if (is_report(output))
            throw UsageError("--report: " + (output == "-" ? "standard output" : output) +
                             " is what the job writes");
    if (!settings.report.empty()) state_ = std::make_unique<State>(settings.report);
}

Report::~Report() = default;

bool Report::is_wanted() const {
    return state_ != nullptr;
}

bool Report::is_standard_output() const {
    return state_ && settings.report == "-";
}

void Report::write(const Json& line) {
    // Numbers that are not finite become null; a name that is not UTF-8 keeps what can be shown.
    if (state_) state_->file.write(line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

void Report::commit() {
    if (state_) state_->file.commit();
}

}  // namespace core
