#include "fetch/client.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "fetch/daemon.h"
#include "fetch/unix_socket.h"
#include "folder.h"

namespace {

using fetch_test::Folder;

TEST(Client, SaysThatNoDaemonRuns) {
    const Folder folder;
    EXPECT_THROW(fetch::Connection({.folder = folder.path, .program = "", .daemon_arguments = {}}),
                 core::Error);
}

// A daemon in this process, with a store that was filled before: no server is needed for what is in the
// cache.
class CachedFile : public ::testing::Test {
  protected:
    static constexpr uint64_t kBytes = 100'000;
    const std::string url_ = "http://127.0.0.1:1/model.qs";

    void SetUp() override {
        fetch::Store store(folder_.path, uint64_t{1} << 30);
        const auto entry = store.create({url_, kBytes, {}});
        entry->put(0, std::span(file_).first(50 * fetch::kBlockBytes));
        entry->put(97, std::span(file_).subspan(97 * fetch::kBlockBytes));
    }

    void run_daemon() {
        fetch::DaemonOptions options;
        options.folder = folder_.path;
        auto daemon = std::make_shared<fetch::Daemon>(options);
        thread_ = std::thread([daemon] { daemon->run(); });
    }
    void TearDown() override {
        if (thread_.joinable()) {
            fetch::Connection({.folder = folder_.path, .program = "", .daemon_arguments = {}}).stop();
            thread_.join();
        }
    }

    Folder folder_;
    std::vector<std::byte> file_ = fetch_test::random_bytes(kBytes);
    std::thread thread_;
};

TEST_F(CachedFile, BlocksThatAreThereAreTheFilesBytes) {
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url_);
    ASSERT_EQ(file->bytes(), kBytes);
    ASSERT_EQ(file->block_count(), 98u);
    for (uint32_t block = 0; block != 98; ++block) {
        const auto bytes = file->block(block);
        if (block >= 50 && block != 97) {
            EXPECT_TRUE(bytes.empty()) << block;
            continue;
        }
        ASSERT_EQ(bytes.size(), block == 97 ? kBytes - 97 * 1024 : 1024) << block;
        EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), file_.begin() + block * 1024)) << block;
    }
}

TEST_F(CachedFile, AWantOfWhatIsThereIsAnsweredAtOnce) {
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url_);
    EXPECT_FALSE(connection.wait(0));
    file->want({{3, 1}});
    EXPECT_TRUE(connection.wait(10));
    EXPECT_FALSE(connection.wait(0.05)) << "once for each want";
}

TEST_F(CachedFile, WhatCannotBeFetchedIsTold) {
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url_);
    file->want({{60, 1}});
    while (file->trouble().empty()) ASSERT_TRUE(connection.wait(10));
    EXPECT_NE(file->trouble().find("connect"), std::string::npos) << file->trouble();
    EXPECT_FALSE(file->block(0).empty()) << "what is there can be read meanwhile";
}

// Where no system call but read, write and exit is allowed, any other one kills.
TEST_F(CachedFile, ABlockThatIsThereCostsNoSystemCall) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers call the system by themselves";
#endif
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url_);
    const pid_t child = ::fork();
    if (child == 0) {
        if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) ::_exit(77);
        size_t bytes = 0;
        for (uint32_t i = 0; i != 1000; ++i) bytes += file->block(i % 98).size();
        ::syscall(SYS_exit, bytes > 0 ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "the system has no seccomp";
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

size_t entries_of(const char* folder) {
    const std::filesystem::directory_iterator begin(folder);
    return size_t(std::distance(begin, std::filesystem::directory_iterator()));
}

size_t maps_of_files() {
    std::ifstream maps("/proc/self/maps");
    size_t count = 0;
    for (std::string line; std::getline(maps, line);) count += line.find("/qs-fetch-") != std::string::npos;
    return count;
}

// Of the daemon, which runs in this process too, and of the client.
TEST_F(CachedFile, TenThousandOpensLeaveNoDescriptorAndNoMap) {
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto keeper = connection.open(url_);
    connection.open(url_);
    const size_t descriptors = entries_of("/proc/self/fd"), maps = maps_of_files();
    for (int i = 0; i != 10'000; ++i) ASSERT_FALSE(connection.open(url_)->block(0).empty()) << i;
    connection.status();  // the last close has been heard
    EXPECT_EQ(entries_of("/proc/self/fd"), descriptors);
    EXPECT_EQ(maps_of_files(), maps);
    EXPECT_GT(maps, 0u);
}

TEST_F(CachedFile, TheEndOfTheDaemonIsSeenAndWhatIsThereStays) {
    run_daemon();
    fetch::Connection connection({.folder = folder_.path, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url_);
    fetch::Connection({.folder = folder_.path, .program = "", .daemon_arguments = {}}).stop();
    thread_.join();
    EXPECT_THROW(connection.wait(10), core::Error);
    EXPECT_FALSE(file->block(0).empty());
}

}  // namespace
