#include "core/program.h"

#include <sys/resource.h>

#include <cmath>
#include <limits>
#include <thread>

#include "child.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/words.h"

namespace {

using core_test::Outcome;
using core_test::read_text;
using core_test::run_in_child;
using core_test::write_text;

constexpr double kNone = std::numeric_limits<double>::infinity();

// A program with one option of each kind, which prints what it understood.
struct Sample {
    core::Program program{"qs-sample", "Try the command line.", "1.2.3"};
    double threshold = 1, low_only = kNone;
    int64_t frames = 240;
    uint64_t memory = 64 << 20;
    double budget_ms = kNone;
    double eye[3] = {NAN, 0, 0};
    std::string operand;

    Sample() {
        program.options.add_option("INPUT", operand, "What to read, - for standard input");
        program.add_number("--threshold", threshold, 0, 1000, "pixels", "Error allowed on the screen");
        program.add_number("--scale", low_only, 0.5, kNone, "", "A factor");
        program.add_integer("--frames", frames, 1, 100000, "Frames of the path");
        program.add_size("--memory", memory, "Memory to use");
        program.add_duration("--budget", budget_ms, 0.5, 1000, "Time to use");
        program.add_numbers("--camera-position", eye, "X,Y,Z", "Where the eye is");
    }
    int run(std::vector<std::string> arguments, const std::function<void()>& job) {
        std::vector<char*> argv{program.name().empty() ? nullptr : const_cast<char*>("qs-sample")};
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        return program.run(static_cast<int>(argv.size() - 1), argv.data(), job);
    }
};

Outcome run(const std::vector<std::string>& arguments, const std::function<void(Sample&)>& job) {
    return run_in_child([&] {
        Sample sample;
        return sample.run(arguments, [&] { job(sample); });
    });
}

Outcome run(const std::vector<std::string>& arguments) {
    return run(arguments, [](Sample& s) {
        core::print(core::text("%s|%.17g|%ld|%lu|%g,%g,%g", s.operand.c_str(), s.threshold, s.frames,
                               s.memory, s.eye[0], s.eye[1], s.eye[2]));
    });
}

class Program : public core_test::InFreshFolder {};

TEST_F(Program, TimesAreMillisecondsUnlessTheySayOtherwise) {
    const auto budget = [](Sample& s) { core::print(core::text("%.17g", s.budget_ms)); };
    const std::pair<std::string, std::string> cases[] = {{"33", "33"},     {"33ms", "33"},  {"0.033s", "33"},
                                                         {"0.5ms", "0.5"}, {"1s", "1000"},  {".01m", "600"},
                                                         {"1e2", "100"},   {"1e-1s", "100"}};
    for (const auto& [given, taken] : cases)
        EXPECT_EQ(run({"in", "--budget", given}, budget).out, taken) << given;
    for (const std::string given : {"", "ms", "s", "33 ms", "33h", "1,5ms", "nans", "0x10"})
        EXPECT_EQ(
            run({"in", "--budget", given}, budget).err,
            "qs-sample: --budget: '" + given +
                "' is not a time; give milliseconds, as in 33, 33ms or 0.033s\ntry 'qs-sample --help'\n");
    for (const std::string given : {"0", "-1ms", "1.001s", "1m", "1e300m", "nan", "inf"})
        EXPECT_EQ(run({"in", "--budget", given}, budget).err.find("qs-sample: --budget: "), 0u) << given;
}

TEST_F(Program, RatesAreBitsASecondInPowersOf1000) {
    const auto rate_of = [](const std::string& given) {
        return run_in_child([&] {
            core::Program program("qs-sample", "Try rates.", "1.2.3");
            double rate = 0;
            core::add_rate(program.options, "--limit-rate", rate, "How fast");
            std::string argument = "--limit-rate=" + given;
            char* argv[] = {const_cast<char*>("qs-sample"), argument.data(), nullptr};
            return program.run(2, argv, [&] { core::print(core::text("%.17g", rate)); });
        });
    };
    const std::pair<std::string, std::string> cases[] = {
        {"9600", "9600"}, {"384k", "384000"}, {"8M", "8000000"}, {"1.5G", "1500000000"}, {"8K", "8000"}};
    for (const auto& [given, taken] : cases) EXPECT_EQ(rate_of(given).out, taken) << given;
    for (const std::string given : {"0", "-1k", "fast", "8MB", "k", "nan", "1e400"})
        EXPECT_EQ(rate_of(given).exit_status, 2) << given;
    EXPECT_EQ(rate_of("8MB").err,
              "qs-sample: --limit-rate: '8MB' is not a rate; give bits a second, as in 384k, 8M or 1G\n"
              "try 'qs-sample --help'\n");
}

TEST_F(Program, NumbersAreTakenAsWritten) {
    const std::pair<std::vector<std::string>, std::string> cases[] = {
        {{}, "|1|240|67108864|nan,0,0"},
        {{"--threshold", "0.1"}, "|0.10000000000000001|240|67108864|nan,0,0"},
        {{"--threshold=1e3", "--frames=+5"}, "|1000|5|67108864|nan,0,0"},
        {{"--threshold", "1e-300"}, "|1e-300|240|67108864|nan,0,0"},
        {{"--threshold", "5", "--threshold", ".5"}, "|0.5|240|67108864|nan,0,0"},
        {{"--memory", "4096"}, "|1|240|4096|nan,0,0"},
        {{"--memory", "3k"}, "|1|240|3072|nan,0,0"},
        {{"--memory", "16G"}, "|1|240|17179869184|nan,0,0"},
        {{"--memory", "17179869183G"}, "|1|240|18446744072635809792|nan,0,0"},
        {{"--camera-position", "-1,-0.5,2e3"}, "|1|240|67108864|-1,-0.5,2000"},
        {{"--camera-position=-1,0,0", "-"}, "-|1|240|67108864|-1,0,0"},
        {{"--", "--frames"}, "--frames|1|240|67108864|nan,0,0"},
    };
    for (const auto& [arguments, expected] : cases) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.out, expected);
        EXPECT_EQ(outcome.err, "");
        EXPECT_EQ(outcome.exit_status, 0);
    }
}

TEST_F(Program, WhatIsNotANumberInRangeIsAUsageError) {
    const std::string size_form = " is not a size; give bytes, as in 4096, 64K, 8M or 2G";
    const std::string point_form = " is not X,Y,Z, 3 numbers with commas between";
    const std::pair<std::vector<std::string>, std::string> cases[] = {
        {{"--threshold", "1,5"}, "--threshold: '1,5' is not a number of pixels; try 1.5"},
        {{"--threshold", "1,5,2"}, "--threshold: '1,5,2' is not a number of pixels"},
        {{"--threshold", "nan"}, "--threshold: 'nan' is not a number of pixels"},
        {{"--threshold", "-inf"}, "--threshold: '-inf' is not a number of pixels"},
        {{"--threshold", "1e999"}, "--threshold: '1e999' is not a number of pixels"},
        {{"--threshold", "1px"}, "--threshold: '1px' is not a number of pixels"},
        {{"--threshold", " 1"}, "--threshold: ' 1' is not a number of pixels"},
        {{"--threshold", "+-1"}, "--threshold: '+-1' is not a number of pixels"},
        {{"--threshold", ""}, "--threshold: '' is not a number of pixels"},
        {{"--threshold", "-5"}, "--threshold: -5 is out of range; it must be from 0 to 1000 pixels"},
        {{"--threshold", "1000.0001"},
         "--threshold: 1000.0001 is out of range; it must be from 0 to 1000 pixels"},
        {{"--scale", "0.4"}, "--scale: 0.4 is out of range; it must be at least 0.5"},
        {{"--frames", "0"}, "--frames: 0 is out of range; it must be from 1 to 100000"},
        {{"--frames", "2.5"}, "--frames: '2.5' is not a whole number"},
        {{"--frames", "9223372036854775808"}, "--frames: '9223372036854775808' is not a whole number"},
        {{"--threads", "-1"}, "--threads: -1 is out of range; it must be from 0 to 1024"},
        {{"--memory", "-5"}, "--memory: '-5'" + size_form},
        {{"--memory", "1.5G"}, "--memory: '1.5G'" + size_form},
        {{"--memory", "5T"}, "--memory: '5T'" + size_form},
        {{"--memory", "4KB"}, "--memory: '4KB'" + size_form},
        {{"--memory", "K"}, "--memory: 'K'" + size_form},
        {{"--memory", "17179869184G"}, "--memory: '17179869184G'" + size_form},
        {{"--memory", "18446744073709551616"}, "--memory: '18446744073709551616'" + size_form},
        {{"--camera-position", "1,2"}, "--camera-position: '1,2'" + point_form},
        {{"--camera-position", "1,2,3,4"}, "--camera-position: '1,2,3,4'" + point_form},
        {{"--camera-position", "1,2,3,"}, "--camera-position: '1,2,3,'" + point_form},
        {{"--camera-position", "1,,3"}, "--camera-position: '1,,3'" + point_form},
        {{"--camera-position", "1,2,nan"}, "--camera-position: '1,2,nan'" + point_form},
        {{"--progress", "perhaps"}, "--progress: 'perhaps' is not auto, always or never"},
        {{"--quiet", "--verbose"}, "--quiet and --verbose exclude each other"},
        {{"--frames="}, "--frames: the value is empty"},
        {{"--frames"}, "--frames: needs a value"},
        {{"--quiet=no"}, "--quiet: takes no value"},
        {{"--verbose=true"}, "--verbose: takes no value"},
        {{"--help="}, "--help: takes no value"},
        {{"--no-such"}, "unknown option '--no-such'"},
        {{"-z"}, "unknown option '-z'"},
        {{"--treshold", "3"}, "unknown option '--treshold'; --threshold may be meant"},
        {{"--cam=1,2,3"}, "unknown option '--cam'; --camera-position may be meant"},
        {{"--frums", "3"}, "unknown option '--frums'; --frames may be meant"},
        {{"--fums"}, "unknown option '--fums'"},
        {{"one", "two"}, "unexpected operand 'two'"},
    };
    for (const auto& [arguments, sentence] : cases) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.err, "qs-sample: " + sentence + "\ntry 'qs-sample --help'\n");
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(outcome.exit_status, 2);
    }
}

TEST_F(Program, AnOptionOfWordsTakesThemAndNoOther) {
    const auto run_with = [](const std::string& word) {
        return run_in_child([&] {
            core::Program program("qs-sample", "Try words.", "1.2.3");
            std::string shade = "lit";
            CLI::Option* option = program.options.add_option("-s,--shade", shade, "How it looks");
            option->check(core::one_of({"lit", "flat", "-x"}))->type_name("MODE");
            const bool is_listed = core::words_of(*option) == std::vector<std::string>{"lit", "flat", "-x"};
            const char* arguments[] = {"qs-sample", "--shade", word.c_str(), nullptr};
            return program.run(word.empty() ? 1 : 3, const_cast<char**>(arguments),
                               [&] { core::print(shade + (is_listed ? "" : " of other words")); });
        });
    };
    for (const std::string word : {"lit", "flat", "-x"}) EXPECT_EQ(run_with(word).out, word);
    EXPECT_EQ(run_with("").out, "lit") << "the default";
    EXPECT_EQ(run_with("fla").exit_status, 2);
    EXPECT_EQ(run_with("lit|flat").err,
              "qs-sample: --shade: 'lit|flat' is not lit, flat or -x\ntry 'qs-sample --help'\n");
}

TEST_F(Program, HelpAndVersionGoToStandardOutput) {
    const Outcome version = run({"--version"});
    EXPECT_EQ(version.out, "qs-sample 1.2.3\n");
    EXPECT_EQ(version.exit_status, 0);
    const Outcome help = run({"--help"});
    EXPECT_EQ(help.exit_status, 0);
    EXPECT_EQ(help.err, "");
    EXPECT_NE(help.out.find("--threshold PIXELS"), std::string::npos);
    EXPECT_NE(help.out.find("Memory to use (default 64M)\n"), std::string::npos);
    EXPECT_NE(help.out.find("Where the eye is\n"), std::string::npos) << "NaN is no default";
    EXPECT_LT(help.out.find("--threshold"), help.out.find("--threads")) << "the program's own come first";
}

TEST_F(Program, SubcommandsTakeTheCommonOptions) {
    for (const bool before : {false, true}) {
        const Outcome outcome = run_in_child([&] {
            core::Program program("qs-sample", "Try subcommands.", "1.2.3");
            double turns = 1;
            CLI::App* orbit = program.options.add_subcommand("orbit", "Fly round");
            core::add_number(*orbit, "--turns", turns, -10, 10, "", "How often");
            program.options.require_subcommand(1);
            const char* after_name[] = {"qs-sample", "orbit", "--turns", "-2", "--threads", "3", nullptr};
            const char* before_name[] = {"qs-sample", "--threads", "3", "orbit", "--turns", "-2", nullptr};
            return program.run(6, const_cast<char**>(before ? before_name : after_name),
                               [&] { core::print(core::text("%g %d", turns, core::thread_count())); });
        });
        EXPECT_EQ(outcome.out, "-2 3");
        EXPECT_EQ(outcome.err, "");
    }
}

TEST_F(Program, AMissingOrUnknownSubcommandIsToldWhatThereIs) {
    const std::pair<const char*, const char*> cases[] = {
        {nullptr, "a subcommand is required: orbit, dolly or walk"},
        {"orbti", "'orbti' is not orbit, dolly or walk"},
        {"--threds=1", "unknown option '--threds'; --threads may be meant"},
    };
    for (const auto& [argument, sentence] : cases) {
        const Outcome outcome = run_in_child([argument = argument] {
            core::Program program("qs-sample", "Try subcommands.", "1.2.3");
            for (const char* name : {"orbit", "dolly", "walk"}) program.options.add_subcommand(name, "Fly");
            program.options.require_subcommand(1);
            const char* arguments[] = {"qs-sample", argument, nullptr};
            return program.run(argument ? 2 : 1, const_cast<char**>(arguments), [] {});
        });
        EXPECT_EQ(outcome.err, std::string("qs-sample: ") + sentence + "\ntry 'qs-sample --help'\n");
        EXPECT_EQ(outcome.exit_status, 2);
    }
}

TEST_F(Program, FailuresEndInOneLineAndTheirStatus) {
    const auto thrown = [](auto error) { return run({}, [&](Sample&) { throw error; }); };
    const Outcome failed = thrown(core::Error("a.ply: line 3: is bad"));
    EXPECT_EQ(failed.err, "qs-sample: a.ply: line 3: is bad\n");
    EXPECT_EQ(failed.exit_status, 1);
    EXPECT_EQ(thrown(core::UsageError("give one of --a and --b")).exit_status, 2);
    EXPECT_EQ(thrown(std::bad_alloc()).err,
              "qs-sample: out of memory: the machine, or a limit like that of 'ulimit -v', gives no more\n");
    EXPECT_EQ(thrown(std::out_of_range("index 3")).err, "qs-sample: index 3\n");
}

TEST_F(Program, AFailedOperandDoesNotEndTheOthers) {
    const Outcome outcome = run({}, [](Sample&) {
        core::fail("a.qs: is bad");
        core::print("b.qs is good\n");
    });
    EXPECT_EQ(outcome.err, "qs-sample: a.qs: is bad\n");
    EXPECT_EQ(outcome.out, "b.qs is good\n");
    EXPECT_EQ(outcome.exit_status, 1);
}

TEST_F(Program, QuietAndVerboseChooseWhatIsSaid) {
    const auto job = [](Sample&) {
        core::notice("three levels");
        core::warn("2 faces dropped");
    };
    EXPECT_EQ(run({}, job).err, "qs-sample: warning: 2 faces dropped\n");
    EXPECT_EQ(run({"--quiet"}, job).err, "");
    EXPECT_EQ(run({"--verbose"}, job).err, "qs-sample: three levels\nqs-sample: warning: 2 faces dropped\n");
}

// A pipe that nobody reads.
class Unread {
  public:
    Unread() {
        int ends[2];
        EXPECT_EQ(::pipe(ends), 0);
        ::close(ends[0]);
        end_ = ends[1];
    }
    ~Unread() { ::close(end_); }
    std::string name() const { return core::text("/dev/fd/%d", end_); }
    void become_standard_output() const { ::dup2(end_, STDOUT_FILENO); }

  private:
    int end_ = -1;
};

const std::string kLongLine(100000, 'x');

TEST_F(Program, AClosedPipeEndsItQuietly) {
    for (const bool as_file : {false, true}) {
        const Unread pipe;
        const Outcome outcome = run_in_child([&] {
            pipe.become_standard_output();
            Sample sample;
            return sample.run({}, [&] {
                std::optional<core::OutputFile> out;
                if (as_file) out.emplace("-");
                for (int i = 0; i < 100; ++i) as_file ? out->write(kLongLine) : core::print(kLongLine);
                core::warn("this is never reached");
            });
        });
        EXPECT_EQ(outcome.exit_status, 0);
        EXPECT_EQ(outcome.err, "");
    }
}

TEST_F(Program, AClosedPipeDoesNotEndOtherOutputs) {
    for (const bool as_file : {false, true}) {
        const Unread pipe;
        const Outcome outcome = run_in_child([&] {
            pipe.become_standard_output();
            Sample sample;
            return sample.run({}, [&] {
                std::optional<core::OutputFile> out, other(as_file ? "first" : "last");
                if (as_file) out.emplace("-");
                for (int i = 0; i < 100; ++i) {
                    as_file ? out->write(kLongLine) : core::print(kLongLine);
                    other->write("line\n");
                }
                if (as_file) out->commit();
                other->commit();
            });
        });
        EXPECT_EQ(outcome.exit_status, 0);
        EXPECT_EQ(outcome.err, "");
        EXPECT_EQ(read_text(as_file ? "first" : "last").size(), 500u);
    }
}

TEST_F(Program, AClosedPipeDoesNotEndOutputsToCome) {
    const Unread pipe;
    const Outcome outcome = run_in_child([&] {
        pipe.become_standard_output();
        Sample sample;
        return sample.run({}, [&] {
            {
                const core::OutputsToCome files;
                core::print(kLongLine);
                core::OutputFile("a").commit();
            }
            core::print(kLongLine);
            core::warn("this is never reached");
        });
    });
    EXPECT_EQ(outcome.exit_status, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(count_files(), 1u);
}

TEST_F(Program, TheLastOfSeveralClosedPipesEndsIt) {
    const Unread first, second;
    const Outcome outcome = run_in_child([&] {
        Sample sample;
        return sample.run({}, [&] {
            core::OutputFile a(first.name()), b(second.name());
            for (int i = 0; i < 10; ++i) a.write(kLongLine);
            a.commit();
            core::warn("the other one is still open");
            for (int i = 0; i < 10; ++i) b.write(kLongLine);
            core::warn("this is never reached");
        });
    });
    EXPECT_EQ(outcome.exit_status, 0);
    EXPECT_EQ(outcome.err, "qs-sample: warning: the other one is still open\n");
}

TEST_F(Program, AFullStandardOutputIsAFailureEvenAtTheLastFlush) {
    const Outcome outcome = run_in_child([] {
        ::dup2(::open("/dev/full", O_WRONLY), STDOUT_FILENO);
        return Sample().run({}, [] { core::print("x"); });
    });
    EXPECT_EQ(outcome.err, "qs-sample: standard output: cannot write: No space left on device\n");
    EXPECT_EQ(outcome.exit_status, 1);
}

TEST_F(Program, ALimitOfFileSizeIsAnErrorAndLeavesNothing) {
    const Outcome outcome = run({}, [](Sample&) {
        const rlimit limit{1000, 1000};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        core::OutputFile file("a");
        file.write(std::string(2000000, 'x'));
        file.commit();
    });
    EXPECT_EQ(outcome.exit_status, 1);
    EXPECT_EQ(outcome.err, "qs-sample: a: cannot write: File too large\n");
    EXPECT_EQ(count_files(), 0u);
}

TEST_F(Program, ProgressIsOneLineAndGoneAtTheEnd) {
    const auto job = [](Sample&) {
        core::Progress progress("reading", 1000);
        core::parallel_for(1000, [&](size_t i) { progress.update(i); });
        core::warn("2 faces dropped");
        progress.update(1000);
    };
    EXPECT_EQ(run({"--progress", "never"}, job).err, "qs-sample: warning: 2 faces dropped\n");
    EXPECT_EQ(run({"--progress", "auto"}, job).err, "qs-sample: warning: 2 faces dropped\n");
    EXPECT_EQ(run({"--progress", "always", "--quiet"}, job).err, "");
    const std::string drawn = run({"--progress", "always"}, job).err;
    EXPECT_TRUE(drawn.starts_with("\rqs-sample: reading 0%\033[K")) << drawn;
    EXPECT_NE(drawn.find("\r\033[Kqs-sample: warning: 2 faces dropped\n"), std::string::npos) << drawn;
    EXPECT_TRUE(drawn.ends_with("\n") || drawn.ends_with("\r\033[K")) << drawn;
}

TEST_F(Program, ProgressIsRedrawnAtMostTenTimesASecond) {
    const Outcome outcome = run({"--progress", "always"}, [](Sample&) {
        core::Progress progress("reading", 0);
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(350);
        while (std::chrono::steady_clock::now() < end) progress.update(7);
    });
    size_t drawn = 0;
    for (size_t at = 0; (at = outcome.err.find("reading", at)) != std::string::npos; ++at) ++drawn;
    EXPECT_GE(drawn, 2u);
    EXPECT_LE(drawn, 5u);
    EXPECT_NE(outcome.err.find("reading 7"), std::string::npos);
}

TEST_F(Program, ReportIsJsonLinesWithNullForWhatIsNotFinite) {
    const auto job = [](Sample&) {
        core::Report report({}, {});
        report.write({{"z_first", 0.1}, {"psnr_db", NAN}, {"nodes", uint64_t{1} << 63}});
        report.write({{"error", -kNone}, {"name", "\xff.ply"}});
        core::print(report.is_wanted() ? "wanted" : "not wanted");
        report.commit();
    };
    EXPECT_EQ(run({"--report", "r.jsonl"}, job).out, "wanted");
    EXPECT_EQ(read_text("r.jsonl"),
              "{\"z_first\":0.1,\"psnr_db\":null,\"nodes\":9223372036854775808}\n"
              "{\"error\":null,\"name\":\"\xef\xbf\xbd.ply\"}\n");
    EXPECT_EQ(run({}, job).out, "not wanted");
    EXPECT_TRUE(run({"--report", "-"}, job).out.ends_with("wanted"));
}

TEST_F(Program, AReportIsNotWrittenOverTheJobsFiles) {
    std::filesystem::create_directory("d");
    write_text("in.ply", "");
    const auto job = [](Sample&) {
        core::Report report({"", "-", "in.ply"}, {"", "d/out.png", "/dev/null"});
    };
    for (const char* name : {"d/out.png", "./d/../d/out.png", "in.ply"})
        EXPECT_EQ(run({"--report", name}, job).exit_status, 2) << name;
    for (const char* name : {"-", "out.png", "/dev/null"})
        EXPECT_EQ(run({"--report", name}, job).exit_status, 0) << name;
    const auto prints = [](Sample&) { core::Report report({}, {"-"}); };
    for (const char* name : {"-", "/dev/stdout", "/dev/fd/1"})
        EXPECT_EQ(run({"--report", name}, prints).exit_status, 2) << name;
    EXPECT_EQ(count_files(), 2u);
}

TEST_F(Program, AReportWithoutCommitLeavesNothing) {
    const auto job = [](Sample&) {
        core::Report report({}, {});
        report.write({{"frame", 0}});
        throw core::Error("the job failed");
    };
    EXPECT_EQ(run({"--report", "r.jsonl"}, job).exit_status, 1);
    EXPECT_EQ(count_files(), 0u);
}

TEST_F(Program, BinaryMayGoIntoAFile) {
    const Outcome outcome = run({}, [](Sample&) {
        core::refuse_binary_to_terminal(false);
        core::refuse_binary_to_terminal(true);
    });
    EXPECT_EQ(outcome.exit_status, 0);
}

TEST_F(Program, BinaryMayGoToATerminalOnlyIfAskedFor) {
    const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
    const bool is_unlocked = master >= 0 && ::grantpt(master) == 0 && ::unlockpt(master) == 0;
    const int terminal = is_unlocked ? ::open(::ptsname(master), O_RDWR | O_NOCTTY) : -1;
    if (terminal < 0) GTEST_SKIP() << "there are no pseudo-terminals here";
    const Outcome outcome = run_in_child([&] {
        ::dup2(terminal, STDOUT_FILENO);
        return Sample().run({}, [] {
            core::refuse_binary_to_terminal(true);
            core::refuse_binary_to_terminal(false);
        });
    });
    EXPECT_EQ(outcome.exit_status, 2);
    EXPECT_NE(outcome.err.find("standard output is a terminal"), std::string::npos);
}

}  // namespace
