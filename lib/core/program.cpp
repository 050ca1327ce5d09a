#include "core/program.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <limits>
#include <mutex>
#include <new>
#include <optional>

#include "core/completion.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/words.h"

namespace core {

namespace {

// What the common options said, for the functions that have no Program at hand.  Written by
// Program before the job starts, read by any thread after.
struct Settings {
    std::string program = "qs";
    std::string progress = "auto";
    std::string report;
    int64_t threads = 0;
    bool quiet = false;
    bool verbose = false;
};
Settings settings;
std::atomic<bool> has_failed{false};

// Standard error holds whole lines and at most one progress line, which is erased before others.
std::mutex talk_mutex;
bool progress_is_drawn = false;

void erase_progress() {
    if (progress_is_drawn) std::fputs("\r\033[K", stderr);
    progress_is_drawn = false;
}

void say(const std::string& line) {
    const std::lock_guard lock(talk_mutex);
    erase_progress();
    std::fputs((settings.program + ": " + line + "\n").c_str(), stderr);
}

// ---- help ----

constexpr size_t kHelpColumns = 110;
constexpr size_t kHelpIndent = 40;  // where the right column starts

// `left`, then `right` wrapped in its column.
std::string two_columns(const std::string& left, const std::string& right) {
    std::string out = "  " + left;
    size_t column = out.size();
    const auto start_line = [&] {
        out += "\n" + std::string(kHelpIndent, ' ');
        column = kHelpIndent;
    };
    if (column + 2 > kHelpIndent) {
        start_line();
    } else {
        out.append(kHelpIndent - column, ' ');
        column = kHelpIndent;
    }
    for (const std::string& word : CLI::detail::split(right, ' ')) {
        if (column > kHelpIndent) {
            if (column + 1 + word.size() > kHelpColumns) {
                start_line();
            } else {
                out += ' ';
                ++column;
            }
        }
        out += word;
        column += word.size();
    }
    return out + "\n";
}

class HelpFormatter : public CLI::Formatter {
  public:
    HelpFormatter() { label("Positionals", "Operands"); }

    std::string make_group(std::string group, bool is_positional,
                           std::vector<const CLI::Option*> options) const override {
        // Of interest to those who install: it would be a line more in each help.
        return group == kCompletionGroup ? "" : Formatter::make_group(group, is_positional, options);
    }

    std::string make_option(const CLI::Option* option, bool is_positional) const override {
        std::string left;
        if (is_positional) {
            left = option->get_name(true);
        } else {
            // "-o, --output FILE"; a long name alone stands under the other long names.
            left = CLI::detail::find_and_replace(option->get_name(false, true), ",", ", ");
            if (option->get_snames().empty()) left = "    " + left;
            if (option->get_type_size() != 0) left += " " + option->get_type_name();
        }
        std::string right = option->get_description();
        const std::string& value = option->get_default_str();
        if (!value.empty() && value != "[]" && value != "\"\"") right += " (default " + value + ")";
        return two_columns(left, right);
    }

    std::string make_subcommand(const CLI::App* app) const override {
        return two_columns(app->get_name(), app->get_description());
    }

    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
        std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
        help = CLI::detail::find_and_replace(help, "\n\n\n", "\n\n");
        while (help.ends_with("\n\n")) help.pop_back();
        if (app->get_parent())
            help += "\nThe common options hold too, see '" + app->get_parent()->get_name() + " --help'.\n";
        return help;
    }
};

// ---- numbers ----

// What messages call the option: its first long name, "--threshold".
std::string shown_name(const std::string& names) {
    for (const std::string& name : CLI::detail::split(names, ','))
        if (name.starts_with("--") || !name.starts_with("-")) return name;
    return names;
}

std::string shortest(double value) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
}

// A finite number that is all of `input`, or nothing.  Independent of the locale.
std::optional<double> parse_double(std::string_view input) {
    if (input.size() > 1 && input[0] == '+' && input[1] != '-') input.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(input.data(), input.data() + input.size(), value);
    if (error != std::errc() || end != input.data() + input.size() || !std::isfinite(value)) return {};
    return value;
}

std::optional<int64_t> parse_integer(std::string_view input) {
    if (input.size() > 1 && input[0] == '+' && input[1] != '-') input.remove_prefix(1);
    int64_t value = 0;
    const auto [end, error] = std::from_chars(input.data(), input.data() + input.size(), value);
    if (error != std::errc() || end != input.data() + input.size()) return {};
    return value;
}

// "; try 1.5" where `input` is a number written with a decimal comma.
std::string hint_for_comma(const std::string& input) {
    std::string with_point = input;
    if (std::count(input.begin(), input.end(), ',') != 1) return "";
    with_point[input.find(',')] = '.';
    return parse_double(with_point) ? "; try " + with_point : "";
}

std::string range_sentence(const std::string& low, const std::string& high, const std::string& unit) {
    const std::string of = unit.empty() ? "" : " " + unit;
    if (high.empty()) return "at least " + low + of;
    if (low.empty()) return "at most " + high + of;
    return "from " + low + " to " + high + of;
}

std::string upper(std::string word) {
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return word;
}

constexpr std::string_view kSizeSuffixes = "KMG";

std::optional<uint64_t> parse_size(std::string_view input) {
    uint64_t value = 0;
    const char* const last = input.data() + input.size();
    const auto [end, error] = std::from_chars(input.data(), last, value);
    if (error != std::errc()) return {};
    if (end == last) return value;
    const char letter = *end >= 'a' ? static_cast<char>(*end - 'a' + 'A') : *end;
    const size_t power = kSizeSuffixes.find(letter);
    if (end + 1 != last || power == std::string_view::npos) return {};
    const unsigned shift = 10 * (static_cast<unsigned>(power) + 1);
    if (value > std::numeric_limits<uint64_t>::max() >> shift) return {};
    return value << shift;
}

// "33ms", "33", "0.033s" or "2m", in milliseconds.
std::optional<double> parse_duration_ms(std::string_view input) {
    constexpr std::pair<std::string_view, double> units[] = {{"ms", 1}, {"s", 1000}, {"m", 60'000}};
    for (const auto& [suffix, ms] : units) {
        if (!input.ends_with(suffix)) continue;
        const std::optional<double> number = parse_double(input.substr(0, input.size() - suffix.size()));
        return number ? std::optional(*number * ms) : std::nullopt;
    }
    return parse_double(input);
}

// "384k", "8M", "1.5G" or "9600", in bits a second; powers of 1000, as rates of links are told.
std::optional<double> parse_rate(std::string_view input) {
    constexpr std::pair<char, double> units[] = {{'k', 1e3}, {'K', 1e3}, {'M', 1e6}, {'G', 1e9}};
    for (const auto& [suffix, factor] : units) {
        if (!input.ends_with(suffix)) continue;
        const std::optional<double> number = parse_double(input.substr(0, input.size() - 1));
        return number ? std::optional(*number * factor) : std::nullopt;
    }
    return parse_double(input);
}

std::string shown_size(uint64_t bytes) {
    std::string suffix;
    for (const char letter : kSizeSuffixes) {
        if (bytes == 0 || bytes % 1024 != 0) break;
        bytes /= 1024;
        suffix = letter;
    }
    return std::to_string(bytes) + suffix;
}

// ---- command line ----

constexpr const char* kHelpNames = "-h,--help";
constexpr const char* kHelpText = "Print this help and exit";

// Thrown when the command line asks for a completion: nothing else is looked at.
struct CallForCompletion {
    std::string shell;
};

void add_common_options(CLI::App& app, const std::string& version) {
    const std::string group = "Common options";
    add_integer(app, "--threads", settings.threads, 0, 1024, "Threads to use, 0 for one per processor")
        ->group(group);
    app.add_flag("--quiet", settings.quiet, "Say nothing but errors")->group(group);
    app.add_flag("--verbose", settings.verbose, "Say more")->group(group);
    app.add_option("--progress", settings.progress, "Draw progress: auto, always or never")
        ->check(one_of({"auto", "always", "never"}))
        ->type_name("WHEN")
        ->group(group);
    app.add_option("--report", settings.report,
                   "Write a report as JSON, one object a line; - for standard output")
        ->type_name("FILE")
        ->group(group);
    app.add_option_function<std::string>("--completion",
                                         [](const std::string& shell) { throw CallForCompletion{shell}; })
        ->check(one_of(completion_shells()))
        ->group(kCompletionGroup);
    app.set_version_flag("--version", version, "Print the version and exit")->group(group);
    app.set_help_flag(kHelpNames, kHelpText)->group(group);
}

bool has_flag(const CLI::App& app, const std::string& name) {
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option) return option->get_items_expected_max() == 0;
    const std::vector<const CLI::App*> subcommands = app.get_subcommands({});
    return std::any_of(subcommands.begin(), subcommands.end(),
                       [&](const CLI::App* subcommand) { return has_flag(*subcommand, name); });
}

// CLI11 takes "--name=" and the next argument for a name and its value, and "--flag=no" for a flag that was
// not given.
void refuse_wrong_values(const CLI::App& app, int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if (argument == "--") return;
        const size_t equals = argument.find('=');
        if (!argument.starts_with("--") || equals == argument.npos) continue;
        const std::string name(argument.substr(0, equals));
        if (has_flag(app, name)) throw UsageError(name + ": takes no value");
        if (equals == argument.size() - 1) throw UsageError(name + ": the value is empty");
    }
}

std::string sentence_from(const CLI::App& app, const CLI::ParseError& error) {
    // An unknown option says more than the operand that is missing because of it.
    std::vector<std::string> extras = app.remaining(true);
    std::erase(extras, "--");
    if (!extras.empty()) {
        const bool is_option = extras.front().size() > 1 && extras.front().starts_with("-");
        return (is_option ? "unknown option '" : "unexpected operand '") + extras.front() + "'";
    }
    std::string sentence = error.what();
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) && sentence.ends_with(" missing"))
        return sentence.substr(0, sentence.find(':')) + ": needs a value";
    std::replace(sentence.begin(), sentence.end(), '\n', ' ');
    if (sentence == "A subcommand is required") return "a subcommand is required";
    return sentence;
}

void check_common_options() {
    if (settings.quiet && settings.verbose) throw UsageError("--quiet and --verbose exclude each other");
}

// Parses; an exit status where there is nothing left to do.
std::optional<int> parse(CLI::App& app, int argc, char** argv) {
    try {
        refuse_wrong_values(app, argc, argv);
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        print(app.help());
        return 0;
    } catch (const CLI::CallForVersion& version) {
        print(std::string(version.what()) + "\n");
        return 0;
    } catch (const CallForCompletion& call) {
        print(completion_script(app, settings.program, call.shell));
        return 0;
    } catch (const CLI::ParseError& error) {
        throw UsageError(sentence_from(app, error));
    }
    check_common_options();
    return {};
}

// The one place where all failures end.
int guarded(const std::function<int()>& body) {
    try {
        const int status = body();
        write_standard_output({}, true);
        return status;
    } catch (const ClosedPipe&) {
        return has_failed ? 1 : 0;
    } catch (const UsageError& error) {
        say(error.what());
        std::fputs(("try '" + settings.program + " --help'\n").c_str(), stderr);
        return 2;
    } catch (const std::bad_alloc&) {
        say("out of memory");
    } catch (const std::exception& error) {
        say(error.what());
    }
    return 1;
}

}  // namespace

Program::Program(std::string name, std::string description, std::string version)
    : options(std::move(description), name), name_(std::move(name)), version_(std::move(version)) {
    settings = Settings();
    settings.program = name_;
    has_failed = false;
    options.formatter(std::make_shared<HelpFormatter>());
    options.option_defaults()->always_capture_default()->multi_option_policy(
        CLI::MultiOptionPolicy::TakeLast);
    options.fallthrough();
    options.set_help_flag(kHelpNames, kHelpText);  // subcommands copy it when they are made
}

int Program::run(int argc, char** argv, const std::function<void()>& job) {
    // A closed pipe then is an error of write(), and what has been begun can be tidied away.
    std::signal(SIGPIPE, SIG_IGN);
    // So is a file beyond the limit of its size (ulimit -f).
    std::signal(SIGXFSZ, SIG_IGN);
    // Last, so that --help lists them below the program's own.
    add_common_options(options, name_ + " " + version_);
    return guarded([&] {
        if (const std::optional<int> status = parse(options, argc, argv)) return *status;
        set_thread_count(static_cast<int>(settings.threads));
        job();
        return has_failed ? 1 : 0;
    });
}

CLI::Option* add_number(CLI::App& app, const std::string& names, double& value, double low, double high,
                        const std::string& unit, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::string of = unit.empty() ? "" : " of " + unit;
        const std::optional<double> number = parse_double(input);
        if (!number)
            throw UsageError(name + ": '" + input + "' is not a number" + of + hint_for_comma(input));
        if (!(*number >= low && *number <= high)) {
            const std::string range = range_sentence(std::isfinite(low) ? shortest(low) : "",
                                                     std::isfinite(high) ? shortest(high) : "", unit);
            throw UsageError(name + ": " + input + " is out of range; it must be " + range);
        }
        value = *number;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name(unit.empty() ? "NUMBER" : upper(unit))
        ->default_str(std::isfinite(value) ? shortest(value) : "");
}

CLI::Option* add_integer(CLI::App& app, const std::string& names, int64_t& value, int64_t low, int64_t high,
                         const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::optional<int64_t> number = parse_integer(input);
        if (!number) throw UsageError(name + ": '" + input + "' is not a whole number");
        if (*number < low || *number > high) {
            const std::string range =
                range_sentence(low > std::numeric_limits<int64_t>::min() ? std::to_string(low) : "",
                               high < std::numeric_limits<int64_t>::max() ? std::to_string(high) : "", "");
            throw UsageError(name + ": " + input + " is out of range; it must be " + range);
        }
        value = *number;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("N")
        ->default_str(std::to_string(value));
}

CLI::Option* add_size(CLI::App& app, const std::string& names, uint64_t& value, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value](const std::string& input) {
        const std::optional<uint64_t> size = parse_size(input);
        if (!size)
            throw UsageError(name + ": '" + input + "' is not a size; give bytes, as in 4096, 64K, 8M or 2G");
        value = *size;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("SIZE")
        ->default_str(shown_size(value));
}

CLI::Option* add_duration(CLI::App& app, const std::string& names, double& value_ms, double low_ms,
                          double high_ms, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &value_ms](const std::string& input) {
        const std::optional<double> ms = parse_duration_ms(input);
        if (!ms)
            throw UsageError(name + ": '" + input +
                             "' is not a time; give milliseconds, as in 33, 33ms or 0.033s");
        if (!(*ms >= low_ms && *ms <= high_ms))
            throw UsageError(name + ": " + input + " is out of range; it must be " +
                             range_sentence(shortest(low_ms), shortest(high_ms), "ms"));
        value_ms = *ms;
    };
    return app.add_option_function<std::string>(names, take, help)
        ->type_name("TIME")
        ->default_str(std::isfinite(value_ms) ? shortest(value_ms) + "ms" : "");
}

CLI::Option* add_rate(CLI::App& app, const std::string& names, double& bits_per_s, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=, &bits_per_s](const std::string& input) {
        const std::optional<double> rate = parse_rate(input);
        if (!rate || !(*rate > 0))
            throw UsageError(name + ": '" + input +
                             "' is not a rate; give bits a second, as in 384k, 8M or 1G");
        bits_per_s = *rate;
    };
    return app.add_option_function<std::string>(names, take, help)->type_name("RATE");
}

CLI::Option* add_numbers(CLI::App& app, const std::string& names, std::span<double> values,
                         const std::string& form, const std::string& help) {
    const std::string name = shown_name(names);
    const auto take = [=](const std::string& input) {
        std::vector<double> numbers;
        size_t begin = 0;
        while (begin <= input.size()) {
            const size_t end = std::min(input.find(',', begin), input.size());
            const std::optional<double> number =
                parse_double(std::string_view(input).substr(begin, end - begin));
            if (!number) break;
            numbers.push_back(*number);
            begin = end + 1;
        }
        if (begin <= input.size() || numbers.size() != values.size())
            throw UsageError(name + ": '" + input + "' is not " + form + ", " +
                             std::to_string(values.size()) + " numbers with commas between");
        std::copy(numbers.begin(), numbers.end(), values.begin());
    };
    std::string shown;
    for (const double value : values) shown += (shown.empty() ? "" : ",") + shortest(value);
    const bool has_default =
        std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    return app.add_option_function<std::string>(names, take, help)
        ->type_name(form)
        ->default_str(has_default ? shown : "");
}

CLI::Option* Program::add_number(const std::string& names, double& value, double low, double high,
                                 const std::string& unit, const std::string& help) {
    return core::add_number(options, names, value, low, high, unit, help);
}

CLI::Option* Program::add_integer(const std::string& names, int64_t& value, int64_t low, int64_t high,
                                  const std::string& help) {
    return core::add_integer(options, names, value, low, high, help);
}

CLI::Option* Program::add_size(const std::string& names, uint64_t& value, const std::string& help) {
    return core::add_size(options, names, value, help);
}

CLI::Option* Program::add_duration(const std::string& names, double& value_ms, double low_ms, double high_ms,
                                   const std::string& help) {
    return core::add_duration(options, names, value_ms, low_ms, high_ms, help);
}

CLI::Option* Program::add_numbers(const std::string& names, std::span<double> values, const std::string& form,
                                  const std::string& help) {
    return core::add_numbers(options, names, values, form, help);
}

void warn(const std::string& sentence) {
    if (!settings.quiet) say("warning: " + sentence);
}

void notice(const std::string& sentence) {
    if (settings.verbose) say(sentence);
}

void fail(const std::string& sentence) {
    has_failed = true;
    say(sentence);
}

void print(std::string_view text) {
    {
        const std::lock_guard lock(talk_mutex);
        erase_progress();
    }
    write_standard_output(text, false);
}

struct Progress::State {
    using Clock = std::chrono::steady_clock;

    std::string what;
    uint64_t total;
    bool drawn;
    std::mutex mutex;
    Clock::time_point next;

    void draw(uint64_t done) {
        std::string line = "\r" + settings.program + ": " + what + " ";
        if (total > 0) {
            line += text("%.0f%%",
                         100.0 * static_cast<double>(std::min(done, total)) / static_cast<double>(total));
        } else {
            line += std::to_string(done);
        }
        const std::lock_guard lock(talk_mutex);
        std::fputs((line + "\033[K").c_str(), stderr);
        progress_is_drawn = true;
        next = Clock::now() + std::chrono::milliseconds(100);
    }
};

Progress::Progress(std::string what, uint64_t total) : state_(std::make_unique<State>()) {
    state_->what = std::move(what);
    state_->total = total;
    const bool wanted =
        settings.progress == "always" || (settings.progress == "auto" && ::isatty(STDERR_FILENO));
    state_->drawn = wanted && !settings.quiet;
    if (state_->drawn) state_->draw(0);
}

Progress::~Progress() {
    if (!state_->drawn) return;
    const std::lock_guard lock(talk_mutex);
    erase_progress();
}

void Progress::update(uint64_t done) {
    if (!state_->drawn) return;
    // A thread that finds another one drawing goes on with its work.
    const std::unique_lock lock(state_->mutex, std::try_to_lock);
    if (lock && State::Clock::now() >= state_->next) state_->draw(done);
}

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
