// Runs code in a child process and in an empty folder: what exits, dies by a signal, or belongs to
// the whole process is tested as a user would see it.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

namespace core_test {

// Whoever started the tests, nohup or a shell's background, may have signals ignored that are waited for
// here.  Before main(), for outputs look only once whether they are.
inline const bool kSignalsAreHeard = [] {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    return true;
}();

inline std::string read_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_text(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

// The working folder of a test: fresh, and gone afterwards.
class InFreshFolder : public testing::Test {
  protected:
    InFreshFolder() : before_(std::filesystem::current_path()) {
        std::string name = testing::TempDir() + "qs-core-XXXXXX";
        if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
        folder_ = name;
        std::filesystem::current_path(folder_);
    }
    ~InFreshFolder() override {
        std::filesystem::current_path(before_);
        std::filesystem::remove_all(folder_);
    }

    static size_t count_files() {
        const std::filesystem::directory_iterator files(".");
        return static_cast<size_t>(std::distance(begin(files), end(files)));
    }

  private:
    std::filesystem::path before_, folder_;
};

struct Outcome {
    int exit_status = -1;  // -1 where a signal ended it
    int signal = 0;
    std::string out, err;
};

// Calls `body` in a child whose standard input is the file `input`; its result is the exit status.
// `meanwhile` is called here with the child's id before the child is waited for.
inline Outcome run_in_child(
    const std::function<int()>& body, const std::string& input = "/dev/null",
    const std::function<void(pid_t)>& meanwhile = [](pid_t) {}) {
    const std::string out = testing::TempDir() + "qs-out-" + std::to_string(::getpid());
    const std::string err = testing::TempDir() + "qs-err-" + std::to_string(::getpid());
    std::fflush(nullptr);  // the child has a copy of what was not written yet
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(::open(input.c_str(), O_RDONLY), STDIN_FILENO);
        ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
        ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
        const int status = body();
        std::fflush(stdout);
        ::_exit(status);
    }
    meanwhile(child);
    int status = 0;
    ::waitpid(child, &status, 0);
    Outcome outcome;
    if (WIFEXITED(status)) outcome.exit_status = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
    outcome.out = read_text(out);
    outcome.err = read_text(err);
    ::unlink(out.c_str());
    ::unlink(err.c_str());
    return outcome;
}

}  // namespace core_test
