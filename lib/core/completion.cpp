#include "core/completion.h"

#include <algorithm>
#include <set>

#include "core/words.h"

namespace core {

namespace {

using Words = std::vector<std::string>;

// ---- what there is to complete ----

enum class Takes { nothing, words, file, folder, other };

struct Value {
    Takes takes = Takes::nothing;
    std::string type;  // as --help shows it
    Words words;
};

struct Row {
    Words names;  // "-o", "--output"
    std::string help;
    Value value;
};

struct Command {
    std::string name, help;
    std::vector<Row> options;
    Value operand;
};

struct Table {
    std::string program;
    Command own;
    std::vector<Command> commands;  // each without the options that `own` has
};

Value value_of(CLI::Option& option, const std::string& type) {
    static const std::set<std::string> files = {"FILE", "NAME",  "OUT",  "TEXT",  "ADDRESS", "A",
                                                "B",    "INPUT", "KEYS", "MODEL", "MESH",    "SOURCE"};
    if (option.get_items_expected_max() == 0) return {};
    const Words words = words_of(option);
    if (!words.empty()) return {Takes::words, type, words};
    if (type == "DIR") return {Takes::folder, type, {}};
    return {files.contains(type) ? Takes::file : Takes::other, type, {}};
}

Row row_of(CLI::Option& option) {
    Row row{{}, option.get_description(), value_of(option, option.get_type_name())};
    for (const std::string& letter : option.get_snames()) row.names.push_back("-" + letter);
    for (const std::string& name : option.get_lnames()) row.names.push_back("--" + name);
    return row;
}

// Options are left out whose names are among `known`.
Command command_of(CLI::App& app, const std::set<std::string>& known) {
    Command command{app.get_name(), app.get_description(), {}, {}};
    for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; })) {
        if (option->get_group() == kCompletionGroup) continue;
        if (option->get_positional()) {
            command.operand = value_of(*option, option->get_name(true));
            continue;
        }
        Row row = row_of(*option);
        if (!known.contains(row.names.back())) command.options.push_back(std::move(row));
    }
    return command;
}

Table table_of(CLI::App& app, const std::string& program) {
    Table table{program, command_of(app, {}), {}};
    std::set<std::string> known;
    for (const Row& row : table.own.options) known.insert(row.names.back());
    for (CLI::App* subcommand : app.get_subcommands([](CLI::App*) { return true; }))
        table.commands.push_back(command_of(*subcommand, known));
    return table;
}

// ---- text ----

std::string joined(const Words& words, const std::string& between) {
    return CLI::detail::join(words, between);
}

Words names_of(const std::vector<Command>& commands) {
    Words names;
    for (const Command& command : commands) names.push_back(command.name);
    return names;
}

Words names_of(const std::vector<Row>& rows) {
    Words names;
    for (const Row& row : rows) names.insert(names.end(), row.names.begin(), row.names.end());
    return names;
}

// `text` with `escape` before each of `characters`.
std::string escaped(const std::string& text, const std::string& characters, const std::string& escape) {
    std::string out;
    for (const char c : text) out += (characters.find(c) != characters.npos ? escape : "") + c;
    return out;
}

// One word for bash and zsh, whatever it holds.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

// "qs-render" as part of a function's name.
std::string identifier(const std::string& program) {
    return CLI::detail::find_and_replace(program, "-", "_");
}

std::string heading(const Table& table, const std::string& shell) {
    return "# Completion of " + table.program + " in " + shell + ", written by: " + table.program +
           " --completion " + shell + "\n";
}

// ---- bash ----

// What readies the answers where `value` stands.
std::string bash_answer(const Value& value) {
    switch (value.takes) {
        case Takes::words:
            return "words=" + quoted(joined(value.words, " "));
        case Takes::file:
            return "names=-f";
        case Takes::folder:
            return "names=-d";
        default:
            return ":";
    }
}

// A case for options after which the same may come, in the order of the first of each; they are told by the
// subcommand, "*" for any, and the word before.
std::string bash_values(const std::vector<Row>& rows, const std::string& command) {
    std::vector<std::pair<std::string, Words>> cases;
    for (const Row& row : rows) {
        if (row.value.takes == Takes::nothing) continue;
        const std::string answer = bash_answer(row.value);
        auto at = std::find_if(cases.begin(), cases.end(), [&](const auto& c) { return c.first == answer; });
        if (at == cases.end()) at = cases.insert(at, {answer, {}});
        for (const std::string& name : row.names) at->second.push_back(command + "," + name);
    }
    std::string out;
    for (const auto& [answer, patterns] : cases)
        out += "        " + joined(patterns, " | ") + ") " + answer + " ;;\n";
    return out;
}

// The case of what is neither: an option, or else what stands where no option does.
std::string bash_rest(const std::string& command, Words options, const std::vector<Row>& common,
                      const Value& operand) {
    const Words more = names_of(common);
    options.insert(options.end(), more.begin(), more.end());
    const Value names{Takes::words, "", options};
    const std::string indent = "\n            ";
    return "        " + command + ",*)" + indent + "if [[ $current == -* ]]; then" + indent + "    " +
           bash_answer(names) + indent + "else" + indent + "    " + bash_answer(operand) + indent + "fi ;;\n";
}

std::string bash_script(const Table& table) {
    const std::string function = "_" + identifier(table.program);
    const Words subcommands = names_of(table.commands);
    std::string out = heading(table, "bash") + function + R"(() {
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command= word
    # --option=value is three words here.
    if [[ $current == = ]]; then
        current=
    elif [[ $previous == = ]]; then
        previous=${COMP_WORDS[COMP_CWORD - 2]}
    fi
)";
    if (!subcommands.empty())
        out += R"(    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        case $word in )" +
               joined(subcommands, " | ") + R"() command=$word && break ;; esac
    done
)";
    out += R"(    # What may come: these words, or names of files (-f) or folders (-d).
    local words= names=
    case $command,$previous in
)";
    for (const Command& command : table.commands) out += bash_values(command.options, command.name);
    out += bash_values(table.own.options, "*");
    for (const Command& command : table.commands)
        out += bash_rest(command.name, names_of(command.options), table.own.options, command.operand);
    const Value first = subcommands.empty() ? table.own.operand : Value{Takes::words, "", subcommands};
    out += bash_rest("*", {}, table.own.options, first);
    return out + R"(    esac
    COMPREPLY=()
    if [[ $names ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen $names -- "$current")
    elif [[ $words ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    fi
}
complete -F )" +
           function + " " + table.program + "\n";
}

// ---- zsh ----

std::string zsh_action(const Value& value) {
    switch (value.takes) {
        case Takes::words:
            return "(" + joined(value.words, " ") + ")";
        case Takes::file:
            return "_files";
        case Takes::folder:
            return "_files -/";
        default:
            return " ";  // nothing but the message
    }
}

// The argument of _arguments that stands for a row: (-o --output){-o+,--output=}[help]:FILE:_files
std::string zsh_option(const Row& row) {
    const bool takes_value = row.value.takes != Takes::nothing;
    const std::string rest =
        "[" + escaped(row.help, "[]\\", "\\") + "]" +
        (takes_value ? ":" + escaped(row.value.type, ":\\", "\\") + ":" + zsh_action(row.value) : "");
    Words names;
    for (const std::string& name : row.names)
        names.push_back(name + (!takes_value ? "" : name.starts_with("--") ? "=" : "+"));
    if (names.size() == 1) return quoted(names[0] + rest);
    return quoted("(" + joined(row.names, " ") + ")") + "{" + joined(names, ",") + "}" + quoted(rest);
}

std::string zsh_rows(const std::vector<Row>& rows, const std::string& indent) {
    std::string out;
    for (const Row& row : rows) out += indent + zsh_option(row) + "\n";
    return out;
}

std::string zsh_operand(const Value& operand) {
    if (operand.takes == Takes::nothing) return "";
    return " " + quoted("*:" + escaped(operand.type, ":\\", "\\") + ":" + zsh_action(operand));
}

std::string zsh_script(const Table& table) {
    std::string out =
        "#compdef " + table.program + "\n" + heading(table, "zsh") +
        "local curcontext=\"$curcontext\" state line\ntypeset -A opt_args\nlocal -a own\nown=(\n" +
        zsh_rows(table.own.options, "    ") + ")\n";
    if (table.commands.empty()) return out + "_arguments -s $own" + zsh_operand(table.own.operand) + "\n";
    out +=
        "_arguments -C -s $own ': :->command' '*:: :->rest' && return\ncase $state in\n    command)\n"
        "        local -a commands\n        commands=(\n";
    for (const Command& command : table.commands)
        out += "            " + quoted(command.name + ":" + escaped(command.help, ":\\", "\\")) + "\n";
    out +=
        "        )\n        _describe -t commands command commands\n        ;;\n    rest)\n"
        "        case $words[1] in\n";
    for (const Command& command : table.commands)
        out += "            " + command.name + ")\n                own+=(\n" +
               zsh_rows(command.options, "                    ") +
               "                )\n                _arguments -s $own" + zsh_operand(command.operand) +
               "\n                ;;\n";
    return out + "        esac\n        ;;\nesac\n";
}

// ---- fish ----

std::string fish_quoted(const std::string& text) {
    return "'" + escaped(text, "\\'", "\\") + "'";
}

// What follows the names of an option, or of a place for operands.
std::string fish_value(const Value& value) {
    switch (value.takes) {
        case Takes::nothing:
            return "";
        case Takes::words:
            return " -x -a " + fish_quoted(joined(value.words, " "));
        case Takes::file:
            return " -r -F";
        case Takes::folder:
            return " -x -a '(__fish_complete_directories)'";
        case Takes::other:
            return " -x";
    }
    return "";
}

std::string fish_rows(const std::string& start, const Command& command) {
    std::string out;
    for (const Row& row : command.options) {
        out += start;
        for (const std::string& name : row.names)
            out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        out += fish_value(row.value) + " -d " + fish_quoted(row.help) + "\n";
    }
    if (command.operand.takes == Takes::file) out += start + " -F\n";
    return out;
}

std::string fish_script(const Table& table) {
    const std::string start = "complete -c " + table.program;
    std::string out = heading(table, "fish") + start + " -f\n" + fish_rows(start, table.own);
    for (const Command& command : table.commands) {
        out += start + " -n __fish_use_subcommand -a " + command.name + " -d " + fish_quoted(command.help) +
               "\n";
        out += fish_rows(start + " -n '__fish_seen_subcommand_from " + command.name + "'", command);
    }
    return out;
}

const std::vector<std::pair<std::string, std::string (*)(const Table&)>> kShells = {
    {"bash", bash_script}, {"zsh", zsh_script}, {"fish", fish_script}};

}  // namespace

const std::vector<std::string>& completion_shells() {
    static const std::vector<std::string> names = [] {
        Words all;
        for (const auto& shell : kShells) all.push_back(shell.first);
        return all;
    }();
    return names;
}

std::string completion_script(CLI::App& options, const std::string& program, const std::string& shell) {
    const auto found =
        std::find_if(kShells.begin(), kShells.end(), [&](const auto& s) { return s.first == shell; });
    return found->second(table_of(options, program));
}

}  // namespace core
