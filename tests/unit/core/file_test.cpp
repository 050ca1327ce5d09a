#include "core/file.h"

#include <sys/stat.h>

#include <csignal>
#include <random>
#include <thread>

#include "child.h"
#include "core/error.h"

namespace {

using core_test::Outcome;
using core_test::read_text;
using core_test::run_in_child;
using core_test::write_text;

std::string text_of(const core::InputFile& file) {
    const auto bytes = file.bytes();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string random_text(size_t size, uint64_t seed) {
    std::mt19937_64 random(seed);
    std::string text(size, '\0');
    for (char& c : text) c = static_cast<char>(random());
    return text;
}

std::string error_of(const std::function<void()>& body) {
    try {
        body();
    } catch (const core::Error& error) {
        return error.what();
    }
    return "";
}

// Sizes about a page, the output's buffer, and the first block of a piped input.
const size_t kSizes[] = {0, 1, 4095, 4096, 4097, 65535, 65536, 65537, 262143, 262144, 262145, 1000003};

class InputFile : public core_test::InFreshFolder {};
class OutputFile : public core_test::InFreshFolder {};
class SameFile : public core_test::InFreshFolder {};

TEST_F(InputFile, HoldsTheBytesOfTheFile) {
    for (const size_t size : kSizes) {
        const std::string text = random_text(size, size);
        write_text("a", text);
        core::InputFile file("a");
        EXPECT_EQ(text_of(file), text);
        EXPECT_EQ(file.name(), "a");
        const core::InputFile moved = std::move(file);
        EXPECT_EQ(text_of(moved), text);
    }
}

TEST_F(InputFile, HoldsTheBytesOfAPipe) {
    ASSERT_EQ(::mkfifo("pipe", 0600), 0);
    for (const size_t size : kSizes) {
        const std::string text = random_text(size, size);
        std::jthread writer([&] { write_text("pipe", text); });
        const core::InputFile file("pipe");
        EXPECT_EQ(text_of(file), text);
        file.forget(0, size);
        EXPECT_EQ(text_of(file), text);
    }
}

TEST_F(InputFile, DashIsStandardInput) {
    write_text("a", "some text");
    const auto body = [] {
        const core::InputFile file("-");
        return file.name() == "standard input" && text_of(file) == "some text" ? 0 : 1;
    };
    EXPECT_EQ(run_in_child(body, "a").exit_status, 0);
}

TEST_F(InputFile, StandardInputStartsWhereTheLastReaderStopped) {
    write_text("a", "some text");
    const auto body = [] {
        char skipped[5];
        return ::read(0, skipped, 5) == 5 && text_of(core::InputFile("-")) == "text" ? 0 : 1;
    };
    EXPECT_EQ(run_in_child(body, "a").exit_status, 0);
}

TEST_F(InputFile, FilesThatClaimToBeEmptyAreReadToTheEnd) {
    EXPECT_GT(core::InputFile("/proc/self/status").bytes().size(), 0u);
}

TEST_F(InputFile, ForgottenBytesAreStillThere) {
    const std::string text = random_text(1 << 20, 3);
    write_text("a", text);
    const core::InputFile file("a");
    for (const auto& [begin, end] :
         {std::pair<size_t, size_t>{0, 1 << 20}, {5000, 5001}, {4095, 9000}, {1, 0}}) {
        file.forget(begin, end);
        EXPECT_EQ(text_of(file), text);
    }
}

TEST_F(InputFile, RefusalsSayWhichAndWhy) {
    EXPECT_EQ(error_of([] { core::InputFile("missing"); }),
              "missing: cannot open: No such file or directory");
    EXPECT_EQ(error_of([] { core::InputFile("."); }), ".: is a directory");
}

TEST_F(OutputFile, HoldsWhatWasWrittenInPieces) {
    for (const size_t size : kSizes) {
        const std::string text = random_text(size, size);
        for (const size_t piece : {size_t{1000}, size_t{262144}, size_t{1000000}}) {
            core::OutputFile file("a");
            for (size_t at = 0; at < size; at += piece) file.write(std::string_view(text).substr(at, piece));
            file.commit();
            EXPECT_EQ(read_text("a"), text);
        }
    }
    EXPECT_EQ(count_files(), 1u);
}

TEST_F(OutputFile, AppearsOnlyWhenCommitted) {
    write_text("a", "old");
    {
        core::OutputFile file("a");
        file.write("new");
        EXPECT_EQ(read_text("a"), "old");
        file.commit();
        EXPECT_EQ(read_text("a"), "new");
    }
    EXPECT_EQ(read_text("a"), "new");
    EXPECT_EQ(count_files(), 1u);
}

TEST_F(OutputFile, LeavesNothingAfterAnException) {
    write_text("a", "old");
    const auto body = [] {
        core::OutputFile file("a");
        file.write(std::string(1000000, 'x'));
        throw core::Error("the job failed");
    };
    EXPECT_EQ(error_of(body), "the job failed");
    EXPECT_EQ(read_text("a"), "old");
    EXPECT_EQ(count_files(), 1u);
}

TEST_F(OutputFile, LeavesNothingAfterASignal) {
    write_text("a", "old");
    ASSERT_EQ(::mkfifo("ready", 0600), 0);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const auto body = [] {
            core::OutputFile first("a"), second("b");
            first.write(std::string(1000000, 'x'));
            write_text("ready", "1");
            for (;;) ::pause();
            return 0;
        };
        const Outcome outcome = run_in_child(body, "/dev/null", [&](pid_t child) {
            EXPECT_EQ(read_text("ready"), "1");
            EXPECT_EQ(count_files(), 4u);
            ::kill(child, signal);
        });
        EXPECT_EQ(outcome.signal, signal);
        EXPECT_EQ(read_text("a"), "old");
        EXPECT_EQ(count_files(), 2u);
    }
}

// Four threads create and finish files without pause; the signal comes at another moment each time.
TEST_F(OutputFile, LeavesNothingWheneverTheSignalComes) {
    for (unsigned delay_us = 100; delay_us < 6100; delay_us += 150) {
        const auto body = [] {
            std::vector<std::jthread> threads;
            for (int t = 0; t < 4; ++t) {
                threads.emplace_back([t] {
                    for (;;) {
                        core::OutputFile file(core::text("out%d", t));
                        file.write("whole");
                        file.commit();
                    }
                });
            }
            return 0;
        };
        const Outcome outcome = run_in_child(body, "/dev/null", [&](pid_t child) {
            while (count_files() == 0) std::this_thread::yield();
            std::this_thread::sleep_for(std::chrono::microseconds(delay_us));
            ::kill(child, SIGTERM);
        });
        EXPECT_EQ(outcome.signal, SIGTERM);
        for (const auto& entry : std::filesystem::directory_iterator(".")) {
            EXPECT_EQ(entry.path().filename().string().substr(0, 3), "out");
            EXPECT_EQ(read_text(entry.path()), "whole");
            std::filesystem::remove(entry.path());
        }
    }
}

TEST_F(OutputFile, KeepsASignalIgnoredThatWasIgnoredBefore) {
    const auto body = [] {
        std::signal(SIGHUP, SIG_IGN);
        core::OutputFile file("a");
        std::raise(SIGHUP);
        file.commit();
        return 0;
    };
    EXPECT_EQ(run_in_child(body).exit_status, 0);
    EXPECT_TRUE(std::filesystem::exists("a"));
}

TEST_F(OutputFile, ModeFollowsTheMask) {
    const mode_t before = ::umask(027);
    core::OutputFile("a").commit();
    ::umask(before);
    EXPECT_EQ(std::filesystem::status("a").permissions(), std::filesystem::perms(0640));
}

TEST_F(OutputFile, FollowsALink) {
    std::filesystem::create_directory("elsewhere");
    write_text("elsewhere/real", "old");
    std::filesystem::create_symlink("elsewhere/real", "link");
    core::OutputFile file("link");
    file.write("new");
    file.commit();
    EXPECT_TRUE(std::filesystem::is_symlink("link"));
    EXPECT_EQ(read_text("elsewhere/real"), "new");
}

TEST_F(OutputFile, TakesANameAsLongAsNamesCanBe) {
    const std::string name(255, 'x');
    core::OutputFile file(name);
    file.write("text");
    file.commit();
    EXPECT_EQ(read_text(name), "text");
}

TEST_F(OutputFile, WritesIntoAPipeInPlace) {
    ASSERT_EQ(::mkfifo("pipe", 0600), 0);
    const std::string text = random_text(1000003, 5);
    std::string received;
    std::jthread reader([&] { received = read_text("pipe"); });
    {
        core::OutputFile file("pipe");
        file.write(text);
        file.commit();
    }
    reader.join();
    EXPECT_EQ(received, text);
    EXPECT_TRUE(std::filesystem::is_fifo("pipe"));
    core::OutputFile("/dev/null").commit();
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(OutputFile, AFullDiskIsReportedWithItsReason) {
    for (const size_t size : {size_t{1}, size_t{1000000}}) {
        const auto body = [&] {
            core::OutputFile file("/dev/full");
            file.write(std::string(size, 'x'));
            file.commit();
        };
        EXPECT_EQ(error_of(body), "/dev/full: cannot write: No space left on device");
    }
}

TEST_F(OutputFile, RefusalsSayWhichAndWhy) {
    EXPECT_EQ(error_of([] { core::OutputFile("."); }), ".: is a directory");
    EXPECT_EQ(error_of([] { core::OutputFile("no/such"); }), "no/such: its folder is missing");
    write_text("plain", "");
    EXPECT_EQ(error_of([] { core::OutputFile("plain/file"); }),
              "plain/file: cannot create a file there: Not a directory");
}

TEST_F(OutputFile, RespectsPermissionsOfFileAndFolder) {
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 0) != 0) GTEST_SKIP() << "cannot give up being root";
    struct Restore {
        ~Restore() { static_cast<void>(::setresuid(0, 0, 0)); }
    };
    const Restore restore;
    std::string name = testing::TempDir() + "qs-closed-XXXXXX";
    ASSERT_TRUE(::mkdtemp(name.data()));
    write_text(name + "/kept", "old");
    ASSERT_EQ(::chmod((name + "/kept").c_str(), 0444), 0);
    EXPECT_EQ(error_of([&] { core::OutputFile(name + "/kept"); }),
              name + "/kept: cannot open for writing: Permission denied");
    ASSERT_EQ(::chmod(name.c_str(), 0555), 0);
    EXPECT_EQ(error_of([&] { core::OutputFile(name + "/new"); }),
              name + "/new: cannot create a file there: Permission denied");
    ::chmod(name.c_str(), 0755);
    std::filesystem::remove_all(name);
}

TEST_F(OutputFile, TooManyAtOnceIsAnError) {
    std::vector<std::unique_ptr<core::OutputFile>> files;
    const auto body = [&] {
        for (int i = 0; i < 65; ++i)
            files.push_back(std::make_unique<core::OutputFile>(core::text("f%d", i)));
    };
    EXPECT_EQ(error_of(body), "more than 64 outputs are open at once");
    EXPECT_EQ(files.size(), 64u);
    files.clear();
    EXPECT_EQ(count_files(), 0u);
    core::OutputFile("again").commit();
    EXPECT_EQ(count_files(), 1u);
}

TEST_F(SameFile, SeesThroughLinks) {
    write_text("a", "text");
    write_text("b", "text");
    std::filesystem::create_symlink("a", "soft");
    std::filesystem::create_hard_link("a", "hard");
    EXPECT_TRUE(core::same_file("a", "a"));
    EXPECT_TRUE(core::same_file("a", "./a"));
    EXPECT_TRUE(core::same_file("soft", "a"));
    EXPECT_TRUE(core::same_file("hard", "soft"));
    EXPECT_FALSE(core::same_file("a", "b"));
    EXPECT_FALSE(core::same_file("a", "missing"));
    EXPECT_FALSE(core::same_file("missing", "missing"));
}

TEST_F(SameFile, TellsWhatWouldBeOverwritten) {
    std::filesystem::create_directory("d");
    std::filesystem::create_directory_symlink("d", "link");
    write_text("d/there", "text");
    std::filesystem::create_symlink("d/there", "soft");
    using core::overwritten_file;
    EXPECT_NE(overwritten_file("d/there"), overwritten_file("d/not_yet"));
    EXPECT_EQ(overwritten_file("soft"), overwritten_file("link/../d/there"));
    EXPECT_EQ(overwritten_file("link/not_yet"), overwritten_file("./d/not_yet"));
    EXPECT_EQ(overwritten_file("not_yet"), overwritten_file("d/../not_yet"));
    EXPECT_NE(overwritten_file("not_yet"), overwritten_file("d/not_yet"));
    for (const char* nothing : {"", "/dev/null"}) EXPECT_EQ(overwritten_file(nothing), "");
}

TEST_F(SameFile, StandardOutputHasOtherNames) {
    const auto body = [] {
        return core::overwritten_file("-") == core::overwritten_file("/dev/stdout") ? 0 : 1;
    };
    EXPECT_EQ(run_in_child(body).exit_status, 0);
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const auto into_pipe = [&] {
        ::dup2(ends[1], STDOUT_FILENO);
        return body() + (core::overwritten_file("-") == core::overwritten_file("/dev/fd/0") ? 1 : 0);
    };
    EXPECT_EQ(run_in_child(into_pipe).exit_status, 0);
    ::close(ends[0]);
    ::close(ends[1]);
}

TEST_F(SameFile, DashIsTheStandardStream) {
    write_text("-", "text");
    write_text("a", "text");
    const auto reads_a = [] { return core::same_file("-", "a") && !core::same_file("-", "./-") ? 0 : 1; };
    EXPECT_EQ(run_in_child(reads_a, "a").exit_status, 0);
    const auto appends_to_a = [] {
        ::dup2(::open("a", O_WRONLY | O_APPEND), STDOUT_FILENO);
        return core::same_file("a", "-") && core::same_file("-", "-") && !core::same_file("./-", "-") ? 0 : 1;
    };
    EXPECT_EQ(run_in_child(appends_to_a, "a").exit_status, 0);
    const auto keeps_nothing = [] {
        ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
        return core::same_file("-", "-") ? 1 : 0;
    };
    EXPECT_EQ(run_in_child(keeps_nothing, "/dev/null").exit_status, 0);
}

}  // namespace
