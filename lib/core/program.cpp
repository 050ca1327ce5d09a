#include "core/program.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <new>
#include <optional>

#include "core/completion.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/settings.h"
#include "core/words.h"

namespace core {

namespace {

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

// "--threshold", of the program and of the subcommand that was named.
std::vector<std::string> long_options(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const CLI::App* subcommand : app.get_subcommands()) {
        const std::vector<std::string> own = long_options(*subcommand);
        names.insert(names.end(), own.begin(), own.end());
    }
    return names;
}

std::string unknown_option(const CLI::App& app, const std::string& argument) {
    const std::string name = argument.substr(0, argument.find('='));
    const std::string likely = name.starts_with("--") ? likely_word(name, long_options(app)) : "";
    return "unknown option '" + name + "'" + (likely.empty() ? "" : "; " + likely + " may be meant");
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* subcommand : app.get_subcommands({})) names.push_back(subcommand->get_name());
    return names;
}

std::string sentence_from(const CLI::App& app, const CLI::ParseError& error) {
    const bool lacks_subcommand = app.get_require_subcommand_min() > 0 && app.get_subcommands().empty();
    // An unknown option says more than the operand that is missing because of it.
    std::vector<std::string> extras = app.remaining(true);
    std::erase(extras, "--");
    if (!extras.empty()) {
        const std::string& first = extras.front();
        if (first.size() > 1 && first.starts_with("-")) return unknown_option(app, first);
        if (lacks_subcommand) return is_not(first, subcommand_names(app));
        return "unexpected operand '" + first + "'";
    }
    if (lacks_subcommand) return "a subcommand is required: " + one_among(subcommand_names(app));
    std::string sentence = error.what();
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) && sentence.ends_with(" missing"))
        return sentence.substr(0, sentence.find(':')) + ": needs a value";
    std::replace(sentence.begin(), sentence.end(), '\n', ' ');
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
        say("out of memory: the machine, or a limit like that of 'ulimit -v', gives no more");
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

}  // namespace core
