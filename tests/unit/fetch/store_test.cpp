#include "fetch/store.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>

#include "folder.h"

namespace {

using fetch::BlockState;
using fetch::Entry;
using fetch::kBlockBytes;
using fetch::Store;
using fetch_test::Folder;
using fetch_test::random_bytes;

constexpr uint64_t kNoLimit = uint64_t{1} << 40;
const std::string kUrl = "http://example.org/model.qs";

fetch::FileFacts facts_of(uint64_t bytes, const std::string& url = kUrl) {
    return {url, bytes, {"\"1\"", "today"}};
}

std::span<const std::byte> blocks_of(const std::vector<std::byte>& file, uint32_t first, uint32_t count) {
    const size_t begin = std::min(file.size(), size_t{first} * kBlockBytes);
    return std::span(file).subspan(begin, std::min(file.size() - begin, size_t{count} * kBlockBytes));
}

std::vector<std::byte> read_data(const Entry& entry) {
    std::vector<std::byte> data(entry.facts().bytes);
    EXPECT_EQ(::pread(entry.data_for_clients(), data.data(), data.size(), 0), ssize_t(data.size()));
    return data;
}

// What a client would see of the entry, without opening it by a Store: how many blocks are marked present,
// all of which must hold the file's bytes.
uint32_t count_present(const std::string& folder, const std::vector<std::byte>& file) {
    const auto text_of = [](const std::string& name) {
        std::ifstream in(name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    std::string map = text_of(folder + "/map");
    if (map.empty()) return 0;
    const std::string data = text_of(folder + "/data");
    const fetch::BlockStates states(reinterpret_cast<std::byte*>(map.data()));
    uint32_t present = 0;
    for (uint32_t block = 0; block != fetch::blocks_in(file.size(), kBlockBytes); ++block) {
        if (states.get(block) != BlockState::present) continue;
        ++present;
        const auto bytes = blocks_of(file, block, 1);
        EXPECT_EQ(std::memcmp(data.data() + size_t{block} * kBlockBytes, bytes.data(), bytes.size()), 0)
            << block;
    }
    return present;
}

template <class Body>
std::string error_of(const Body& body) {
    try {
        body();
    } catch (const core::Error& error) {
        return error.what();
    }
    return "";
}

TEST(Store, KeepsBlocksFromOneRunToTheNext) {
    const Folder folder;
    const auto file = random_bytes(10 * kBlockBytes + 100);
    {
        Store store(folder.path + "/a/b", kNoLimit);
        EXPECT_EQ(store.find(kUrl), nullptr);
        const auto entry = store.create(facts_of(file.size()));
        EXPECT_EQ(entry->block_count(), 11u);
        EXPECT_EQ(entry->size_of(10), 100u);
        entry->put(3, blocks_of(file, 3, 2));
        entry->put(10, blocks_of(file, 10, 1));
        entry->set_state(1, BlockState::wanted);
        entry->set_state(2, BlockState::requested);
        EXPECT_EQ(store.find(kUrl), entry);
    }
    Store store(folder.path + "/a/b", kNoLimit);
    const auto entry = store.find(kUrl);
    ASSERT_NE(entry, nullptr);
    EXPECT_EQ(entry->facts().bytes, file.size());
    EXPECT_EQ(entry->facts().validator, (fetch::Validator{"\"1\"", "today"}));
    EXPECT_EQ(entry->present_count(), 3u);
    const auto data = read_data(*entry);
    for (uint32_t block = 0; block != 11; ++block) {
        const bool is_present = block == 3 || block == 4 || block == 10;
        EXPECT_EQ(entry->state(block), is_present ? BlockState::present : BlockState::absent) << block;
        if (is_present) {
            const auto bytes = blocks_of(file, block, 1);
            EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), data.begin() + block * kBlockBytes));
        }
    }
}

// Fills the store again and again until it is killed; says when it starts, or (three times of four) has begun
// to write.
[[noreturn]] void write_for_ever(const std::string& path, const std::vector<std::byte>& file, unsigned seed,
                                 int started) {
    std::mt19937 random(seed);
    Store store(path, kNoLimit);
    bool has_said = false;
    const auto say = [&] {
        if (!has_said && ::write(started, "", 1) != 1) std::abort();
        has_said = true;
    };
    if (seed % 4 == 0) say();
    for (;;) {
        auto entry = store.find(kUrl);
        // The last blocks would be long in coming.
        const auto is_nearly_full = [&] { return entry->present_count() > entry->block_count() / 8 * 7; };
        if (!entry || is_nearly_full()) entry = store.create(facts_of(file.size()));
        while (!is_nearly_full()) {
            const uint32_t first = uint32_t(random()) % entry->block_count();
            const uint32_t count = std::min(1 + uint32_t(random()) % 4, entry->block_count() - first);
            if (entry->state(first) != BlockState::present) entry->put(first, blocks_of(file, first, count));
            say();
        }
    }
}

TEST(Store, EveryBlockMarkedPresentIsThereAfterAKillAtAnyInstant) {
    // In memory where there is such a disk: most of the time is to be spent in writing blocks, not in making
    // files.
    const Folder folder(std::filesystem::exists("/dev/shm") ? "/dev/shm"
                                                            : std::filesystem::temp_directory_path());
    const auto file = random_bytes(2 << 20);
    std::mt19937 random(7);
    uint32_t kept = 0;
    for (unsigned run = 0; run != 200; ++run) {
        int started[2];
        ASSERT_EQ(::pipe(started), 0);
        const pid_t child = ::fork();
        if (child == 0) write_for_ever(folder.path, file, run, started[1]);
        ::close(started[1]);
        char byte;
        EXPECT_EQ(::read(started[0], &byte, 1), 1);
        ::close(started[0]);
        ::usleep(unsigned(random()) % 6000);
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        const uint32_t present = count_present(folder.path + "/" + fetch::id_of(kUrl), file);
        Store store(folder.path, kNoLimit);
        const auto entry = store.find(kUrl);
        ASSERT_EQ(entry ? entry->present_count() : 0, present) << "the next run goes on from there";
        kept += present > 0;
    }
    EXPECT_GT(kept, 20u) << "the kills came before anything was written";
}

TEST(Store, AfterTheSystemWentDownProvesWhatIsMarkedPresent) {
    const Folder folder;
    const auto file = random_bytes(8 * kBlockBytes);
    {
        Store store(folder.path, kNoLimit);
        store.create(facts_of(file.size()))->put(0, blocks_of(file, 0, 6));
    }
    const std::string id = folder.path + "/" + fetch::id_of(kUrl);
    {
        // Block 2 did not reach the disk, nor the sum of block 4; another boot.
        std::fstream data(id + "/data", std::ios::in | std::ios::out),
            sums(id + "/sums", std::ios::in | std::ios::out);
        data.seekp(2 * kBlockBytes).write("\0\0\0\0", 4);
        sums.seekp(4 * 8).write("\0\0\0\0\0\0\0\0", 8);
        std::fstream map(id + "/map", std::ios::in | std::ios::out);
        map.seekp(offsetof(fetch::MapHeader, boot_id)).write("another", 8);
    }
    for (int run = 0; run != 2; ++run) {
        Store store(folder.path, kNoLimit);
        const auto entry = store.find(kUrl);
        ASSERT_NE(entry, nullptr);
        std::string states;
        for (uint32_t block = 0; block != 8; ++block)
            states += entry->state(block) == BlockState::present ? 'x' : '.';
        EXPECT_EQ(states, "xx.x.x..");
    }
}

TEST(Store, DamagedEntriesAreRemovedAndFetchedAnew) {
    const Folder folder;
    const std::string id = folder.path + "/" + fetch::id_of(kUrl);
    const std::function<void()> damages[] = {
        [&] { std::filesystem::resize_file(id + "/map", 100); },
        [&] { std::filesystem::resize_file(id + "/data", 100); },
        [&] { std::filesystem::resize_file(id + "/sums", 0); },
        [&] { std::filesystem::remove(id + "/use"); },
        [&] { std::filesystem::remove(id + "/facts"); },
        [&] { std::ofstream(id + "/facts") << "{\"url\": 3"; },
        [&] { std::ofstream(id + "/facts") << "{\"url\": \"" << kUrl << "\", \"bytes\": -1}"; },
        [&] { std::ofstream(id + "/facts", std::ios::app) << std::string(1 << 17, ' '); },
        [&] { std::fstream(id + "/map", std::ios::in | std::ios::out) << "nonsense"; },
        [&] {
            std::filesystem::remove(id + "/data");
            std::filesystem::create_symlink("/etc/passwd", id + "/data");
        },
    };
    for (const auto& damage : damages) {
        {
            Store store(folder.path, kNoLimit);
            store.create(facts_of(5000));
        }
        damage();
        Store store(folder.path, kNoLimit);
        EXPECT_EQ(store.find(kUrl), nullptr) << &damage - damages;
        EXPECT_FALSE(std::filesystem::exists(id)) << &damage - damages;
    }
}

TEST(Store, AnotherUrlOfTheSameNameIsNotTaken) {
    const Folder folder;
    {
        Store store(folder.path, kNoLimit);
        store.create(facts_of(5000, "http://example.org/other"));
    }
    std::filesystem::rename(folder.path + "/" + fetch::id_of("http://example.org/other"),
                            folder.path + "/" + fetch::id_of(kUrl));
    Store store(folder.path, kNoLimit);
    EXPECT_EQ(store.find(kUrl), nullptr);
}

TEST(Store, ARemovedEntryServesThoseWhoHoldIt) {
    const Folder folder;
    const auto file = random_bytes(4 * kBlockBytes), later = random_bytes(6 * kBlockBytes, 2);
    Store store(folder.path, kNoLimit);
    const auto old = store.create(facts_of(file.size()));
    old->put(0, blocks_of(file, 0, 2));
    const auto fresh = store.create(facts_of(later.size()));
    old->put(2, blocks_of(file, 2, 2));
    fresh->put(0, blocks_of(later, 0, 6));
    EXPECT_EQ(read_data(*old), file);
    EXPECT_EQ(read_data(*fresh), later);
    store.remove(kUrl);
    EXPECT_EQ(store.find(kUrl), nullptr);
    EXPECT_EQ(read_data(*fresh), later);
}

TEST(Store, RefusesWhatItCannotHold) {
    const Folder folder;
    Store store(folder.path, kNoLimit);
    EXPECT_NE(error_of([&] { store.create(facts_of(0)); }), "");
    EXPECT_NE(error_of([&] { store.create(facts_of(fetch::kMostFileBytes + 1)); }), "");
    EXPECT_EQ(store.entry_count(), 0u);
}

TEST(Store, HoldsAtMostItsLimitAndLetsTheLongestUnusedGo) {
    const Folder folder;
    constexpr uint64_t kLimit = 1 << 20, kFile = 300 << 10;
    const auto file = random_bytes(kFile);
    Store store(folder.path, kLimit);
    for (int i = 0; i != 6; ++i) {
        const std::string url = kUrl + std::to_string(i);
        const auto entry = store.create(facts_of(kFile, url));
        for (uint32_t block = 0; block != entry->block_count(); block += 10) {
            ASSERT_TRUE(store.make_room(16 * kBlockBytes));
            entry->put(block, blocks_of(file, block, 10));
            EXPECT_LE(store.held_bytes(), kLimit);
        }
        // Seconds decide, and the test shall not wait for them.
        const timespec times[2] = {{100 + i, 0}, {100 + i, 0}};
        ::utimensat(AT_FDCWD, (folder.path + "/" + fetch::id_of(url)).c_str(), times, 0);
    }
    EXPECT_EQ(store.find(kUrl + "0"), nullptr);
    EXPECT_EQ(store.find(kUrl + "1"), nullptr);
    EXPECT_NE(store.find(kUrl + "5"), nullptr);
    EXPECT_EQ(read_data(*store.find(kUrl + "5")), file);
    EXPECT_GE(store.evicted_bytes(), 3 * kFile);
}

void set_use(const Entry& entry, uint32_t chunk, uint32_t use) {
    EXPECT_EQ(::pwrite(entry.use_for_clients(), &use, sizeof use, chunk * sizeof use), ssize_t(sizeof use));
}

TEST(Store, EvictsOfOpenFilesWhatNobodyReads) {
    const Folder folder;
    const auto file = random_bytes(1 << 20);
    Store store(folder.path, kNoLimit);
    const auto entry = store.create(facts_of(file.size()));
    entry->put(0, file);
    const uint64_t all = store.held_bytes();
    store.shrink_to(0);
    EXPECT_EQ(entry->present_count(), 1024u) << "what has just come is in use";

    for (uint32_t chunk = 0; chunk != 16; ++chunk) set_use(*entry, chunk, chunk < 4 ? fetch::use_clock() : 0);
    store.shrink_to(all - 3 * fetch::kChunkBytes);
    EXPECT_EQ(entry->present_count(), 1024u - 3 * 64);
    EXPECT_LE(store.held_bytes(), all - 3 * fetch::kChunkBytes);
    EXPECT_EQ(store.evicted_bytes(), 3 * fetch::kChunkBytes);

    entry->set_state(5 * 64, BlockState::absent);
    entry->set_state(5 * 64, BlockState::requested);
    store.shrink_to(0);
    for (uint32_t chunk = 0; chunk != 16; ++chunk) {
        const bool is_kept = chunk < 4;
        EXPECT_EQ(entry->state(chunk * 64 + 1), is_kept ? BlockState::present : BlockState::absent) << chunk;
    }
    const auto data = read_data(*entry);
    EXPECT_TRUE(std::equal(file.begin(), file.begin() + 4 * fetch::kChunkBytes, data.begin()));
}

TEST(Store, TakesNoRoomThatIsInUse) {
    const Folder folder;
    const auto file = random_bytes(512 << 10);
    Store store(folder.path, 256 << 10);
    const auto entry = store.create(facts_of(file.size()));
    uint32_t block = 0;
    while (block < entry->block_count() && store.make_room(24 * kBlockBytes)) {
        entry->put(block, blocks_of(file, block, 16));
        block += 16;
    }
    EXPECT_GT(block, 64u);
    EXPECT_LT(block, 256u);
    EXPECT_LE(store.held_bytes(), 256u << 10);
    EXPECT_EQ(entry->present_count(), block);
}

TEST(Store, BelongsToOneProcess) {
    const Folder folder;
    Store store(folder.path, kNoLimit);
    EXPECT_EQ(error_of([&] { Store second(folder.path, kNoLimit); }),
              folder.path + ": is in use by another qs-fetch, process " + std::to_string(::getpid()));
}

TEST(Store, RefusesFoldersOfOthers) {
    const Folder folder;
    ::chmod(folder.path.c_str(), 0755);
    EXPECT_EQ(error_of([&] { Store store(folder.path, kNoLimit); }),
              folder.path + ": is open to others (mode 755); close it by 'chmod 700'");
    ::chmod(folder.path.c_str(), 0700);
    if (::chown(folder.path.c_str(), 12345, 12345) != 0)
        GTEST_SKIP() << "only root can make folders of others";
    EXPECT_NE(error_of([&] { Store store(folder.path, kNoLimit); }).find("belongs to user 12345"),
              std::string::npos);
    ASSERT_EQ(::chown(folder.path.c_str(), ::geteuid(), ::getegid()), 0);
}

TEST(Store, MakesItsFoldersPrivate) {
    const Folder folder;
    const mode_t before = ::umask(0);
    const Store store(folder.path + "/x/y", kNoLimit);
    ::umask(before);
    struct stat status = {};
    ASSERT_EQ(::stat((folder.path + "/x/y").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700u);
}

TEST(Store, SaysThatItsFolderIsGone) {
    const Folder folder;
    Store store(folder.path + "/cache", kNoLimit);
    std::filesystem::remove_all(folder.path + "/cache");
    EXPECT_NE(error_of([&] { store.create(facts_of(5000)); }).find("No such file"), std::string::npos);
    EXPECT_EQ(store.find(kUrl), nullptr);
}

// A disk of one megabyte.
class SmallDisk : public ::testing::Test {
  protected:
    void SetUp() override {
        if (::mount("none", folder_.path.c_str(), "tmpfs", 0, "size=1M,mode=700") != 0)
            GTEST_SKIP() << "needs the right to mount a file system";
        is_mounted_ = true;
    }
    void TearDown() override {
        if (is_mounted_) ::umount2(folder_.path.c_str(), MNT_DETACH);
    }
    Folder folder_;
    bool is_mounted_ = false;
};

TEST_F(SmallDisk, FullKeepsWhatIsThereAndSaysSo) {
    const auto file = random_bytes(2 << 20);
    Store store(folder_.path, kNoLimit);
    const auto entry = store.create(facts_of(file.size()));
    uint32_t block = 0;
    EXPECT_THROW(
        {
            for (; block != entry->block_count(); block += 16) entry->put(block, blocks_of(file, block, 16));
        },
        fetch::DiskFull);
    EXPECT_GT(block, 256u);
    EXPECT_EQ(entry->present_count(), block);
    EXPECT_THROW(store.create(facts_of(uint64_t{64} << 30, "http://example.org/larger")), fetch::DiskFull);
    EXPECT_EQ(store.entry_count(), 1u);
    const auto data = read_data(*entry);
    EXPECT_TRUE(std::equal(data.begin(), data.begin() + block * kBlockBytes, file.begin()));
    // Room on the disk lets it go on.
    for (uint32_t chunk = 0; chunk != 32; ++chunk) set_use(*entry, chunk, 0);
    store.shrink_to(512 << 10);
    entry->put(block, blocks_of(file, block, 16));
}

TEST_F(SmallDisk, ReadOnlyIsSaidAtOnce) {
    ASSERT_EQ(::mount("none", folder_.path.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "size=1M,mode=700"), 0);
    EXPECT_NE(error_of([&] { Store store(folder_.path, kNoLimit); }).find("Read-only file system"),
              std::string::npos);
}

}  // namespace
