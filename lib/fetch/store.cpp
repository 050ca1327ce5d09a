#include "fetch/store.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "fetch/private_folder.h"

namespace fetch {

namespace {

constexpr char kMagic[8] = "qsfetch";
constexpr uint32_t kMapVersion = 1;
constexpr off_t kMostFactsBytes = 64 * 1024;
constexpr std::array kParts = {"data", "sums", "map", "use", "facts"};
constexpr const char* kUnfinished = "new-entry";  // one is made at a time
constexpr const char* kLeaving = "old-entry";

std::string current_boot() {
    const Descriptor file(::open("/proc/sys/kernel/random/boot_id", O_RDONLY | O_CLOEXEC));
    std::array<char, 37> id = {};
    const ssize_t size = file ? ::read(file.get(), id.data(), id.size() - 1) : -1;
    if (size != ssize_t(id.size() - 1)) throw core::Error("/proc/sys/kernel/random/boot_id: cannot be read");
    return id.data();
}

void write_at(int fd, const void* data, size_t size, uint64_t offset, const std::string& name) {
    const char* at = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t written = ::pwrite(fd, at, size, off_t(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail_with_errno(name, "cannot write");
        at += written;
        size -= size_t(written);
        offset += uint64_t(written);
    }
}

// False where there are fewer bytes.
bool read_at(int fd, void* data, size_t size, uint64_t offset) {
    char* at = static_cast<char*>(data);
    while (size > 0) {
        const ssize_t got = ::pread(fd, at, size, off_t(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got;
        size -= size_t(got);
        offset += uint64_t(got);
    }
    return true;
}

uint64_t allocated_by(int fd) {
    struct stat status = {};
    return ::fstat(fd, &status) == 0 ? uint64_t(status.st_blocks) * 512 : 0;
}

uint64_t length_of(int fd) {
    struct stat status = {};
    return ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode) ? uint64_t(status.st_size) : 0;
}

// Within the time for which a block that was seen present may be read.
bool is_recent(uint32_t use) {
    const uint32_t now = use_clock();
    return use != 0 && use <= now && now - use <= kGraceSeconds;
}

// The sum of a hole is 0, which no block may have.
uint64_t sum_of(std::span<const std::byte> block) {
    return XXH3_64bits(block.data(), block.size()) | 1;
}

Descriptor make_part(int folder, const char* part, const std::string& name) {
    Descriptor file(::openat(folder, part, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!file) fail_with_errno(name, "cannot make the file");
    return file;
}

// Of its full length, without holes: what clients and we write through maps.
Descriptor make_full_part(int folder, const char* part, size_t bytes, const std::string& name) {
    Descriptor file = make_part(folder, part, name);
    if (const int reason = ::posix_fallocate(file.get(), 0, off_t(bytes)); reason != 0) {
        errno = reason;
        fail_with_errno(name, "cannot make the file");
    }
    return file;
}

Descriptor make_sparse_part(int folder, const char* part, uint64_t bytes, const std::string& name) {
    Descriptor file = make_part(folder, part, name);
    if (::ftruncate(file.get(), off_t(bytes)) != 0) fail_with_errno(name, "cannot make the file");
    return file;
}

void remove_entry_folder(int parent, const std::string& id) {
    const Descriptor folder(::openat(parent, id.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (folder)
        for (const char* part : kParts) ::unlinkat(folder.get(), part, 0);
    ::unlinkat(parent, id.c_str(), AT_REMOVEDIR);
}

nlohmann::json to_json(const FileFacts& facts, uint32_t block_bytes) {
    return {{"url", facts.url},
            {"bytes", facts.bytes},
            {"block_bytes", block_bytes},
            {"etag", facts.validator.etag},
            {"last_modified", facts.validator.last_modified}};
}

struct StoredFacts {
    FileFacts facts;
    uint32_t block_bytes;
};

// Nothing where the file is not what create() writes.
std::optional<StoredFacts> read_facts(int folder) {
    const Descriptor file(::openat(folder, "facts", O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    struct stat status = {};
    if (!file || ::fstat(file.get(), &status) != 0 || status.st_size > kMostFactsBytes) return {};
    std::string text(size_t(status.st_size), '\0');
    if (!read_at(file.get(), text.data(), text.size(), 0)) return {};
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    try {
        const StoredFacts read{
            {json.at("url"), json.at("bytes"), {json.at("etag"), json.at("last_modified")}},
            json.at("block_bytes")};
        // Whole blocks in a chunk, whole pages of the map.
        const bool is_sound = read.block_bytes >= 512 && kChunkBytes % read.block_bytes == 0 &&
                              read.facts.bytes > 0 && read.facts.bytes <= kMostFileBytes;
        return is_sound ? std::optional(read) : std::nullopt;
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

}  // namespace

std::string id_of(const std::string& url) {
    const XXH128_hash_t hash = XXH3_128bits(url.data(), url.size());
    return core::text("%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                      static_cast<unsigned long long>(hash.low64));
}

// ---- Entry ----

uint32_t Entry::size_of(uint32_t block) const {
    const uint64_t begin = uint64_t{block} * block_bytes_;
    return uint32_t(std::min<uint64_t>(block_bytes_, facts_.bytes - begin));
}

void Entry::put(uint32_t first, std::span<const std::byte> bytes) {
    const uint32_t count = uint32_t(blocks_in(bytes.size(), block_bytes_));
    std::vector<uint64_t> sums(count);
    for (uint32_t i = 0; i != count; ++i)
        sums[i] = sum_of(bytes.subspan(size_t{i} * block_bytes_, size_of(first + i)));
    write_at(data_.get(), bytes.data(), bytes.size(), uint64_t{first} * block_bytes_, name_ + "/data");
    write_at(sums_.get(), sums.data(), sums.size() * sizeof(uint64_t), first * sizeof(uint64_t),
             name_ + "/sums");
    note_use(first, first + count - 1);
    for (uint32_t block = first; block != first + count; ++block) {
        present_count_ += state(block) != BlockState::present;
        states_.set(block, BlockState::present);
    }
    note_allocated();
}

// What has just come is used soon: it must not be the first to go.  Not through a map, which a client could
// cut off.
void Entry::note_use(uint32_t first, uint32_t last) {
    const uint32_t a_chunk = kChunkBytes / block_bytes_, now = use_clock();
    for (uint32_t chunk = first / a_chunk; chunk <= last / a_chunk; ++chunk) {
        if (chunk == noted_chunk_ && now == noted_use_) continue;
        write_at(use_.get(), &now, sizeof now, chunk * sizeof now, name_ + "/use");
        noted_chunk_ = chunk;
        noted_use_ = now;
    }
}

void Entry::confirm() {
    const int64_t now = ::time(nullptr);
    if (now == confirmed_at_) return;
    confirmed_at_ = now;
    // Where this fails, the server is asked once more.
    ::futimens(facts_file_.get(), nullptr);
}

void Entry::mark_replaced() {
    std::atomic_ref(reinterpret_cast<MapHeader*>(map_.data())->is_replaced).store(1);
}

void Entry::open_parts(int folder, const std::string& name) {
    name_ = name;
    const auto open = [&](const char* part, int flags) {
        Descriptor file(::openat(folder, part, flags | O_NOFOLLOW | O_CLOEXEC));
        if (!file) fail_with_errno(name + "/" + part, "cannot open");
        return file;
    };
    data_ = open("data", O_RDWR);
    sums_ = open("sums", O_RDWR);
    map_file_ = open("map", O_RDWR);
    use_ = open("use", O_RDWR);
    facts_file_ = open("facts", O_RDONLY);
    struct stat facts = {};
    if (::fstat(facts_file_.get(), &facts) == 0) confirmed_at_ = facts.st_mtim.tv_sec;
    data_for_clients_ = open("data", O_RDONLY);
    map_for_clients_ = open("map", O_RDONLY);
    if (length_of(data_.get()) != facts_.bytes ||
        length_of(sums_.get()) != block_count() * sizeof(uint64_t) ||
        length_of(map_file_.get()) != map_bytes(block_count()) ||
        length_of(use_.get()) != use_bytes(facts_.bytes))
        throw core::Error(name + ": a file is of the wrong length");
    map_ = FileMap(map_file_.get(), map_bytes(block_count()), true, name + "/map");
    states_ = BlockStates(map_.data());
    const auto* header = reinterpret_cast<const MapHeader*>(map_.data());
    if (std::memcmp(header->magic, kMagic, sizeof kMagic) != 0 || header->version != kMapVersion ||
        header->block_bytes != block_bytes_ || header->file_bytes != facts_.bytes)
        throw core::Error(name + ": the map is of another file");
    check_blocks();
    note_allocated();
}

// What was under way when the last process ended is nobody's any more; what is marked present is proved where
// the system has been started anew since.
void Entry::check_blocks() {
    auto* header = reinterpret_cast<MapHeader*>(map_.data());
    const std::string boot = current_boot();
    const bool is_proved = std::strncmp(header->boot_id, boot.c_str(), sizeof header->boot_id) == 0;
    std::vector<std::byte> bytes(block_bytes_);
    for (uint32_t block = 0; block != block_count(); ++block) {
        bool is_present = state(block) == BlockState::present;
        if (is_present && !is_proved) {
            uint64_t sum = 0;
            is_present = read_at(data_.get(), bytes.data(), size_of(block), uint64_t{block} * block_bytes_) &&
                         read_at(sums_.get(), &sum, sizeof sum, block * sizeof sum) &&
                         sum == sum_of(std::span(bytes).first(size_of(block)));
        }
        if (!is_present && state(block) != BlockState::absent) set_state(block, BlockState::absent);
        present_count_ += is_present;
    }
    std::memcpy(header->boot_id, boot.c_str(), boot.size() + 1);
}

void Entry::note_allocated() {
    allocated_ = allocated_by(data_.get()) + allocated_by(sums_.get()) + allocated_by(map_file_.get()) +
                 allocated_by(use_.get());
}

// ---- Store ----

struct Store::Chunk {
    std::shared_ptr<Entry> entry;
    uint32_t index;
    uint32_t last_use;
};

Store::Store(const std::string& path, uint64_t limit_bytes)
    : path_(path),
      limit_bytes_(limit_bytes),
      folder_(open_private_folder(path)),
      lock_(lock_folder(folder_.get(), path)) {
    const int punch = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
    // Beyond the lock file's few bytes.
    if (::fallocate(lock_.get(), punch, kChunkBytes, kChunkBytes) != 0)
        fail_with_errno(path, "the file system cannot make holes in files, which a cache needs");
    remove_entry_folder(folder_.get(), kUnfinished);
    remove_entry_folder(folder_.get(), kLeaving);
    scan();
}

Store::~Store() = default;

void Store::scan() {
    const int fd = ::openat(folder_.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR* const listing = fd < 0 ? nullptr : ::fdopendir(fd);
    if (!listing) fail_with_errno(path_, "cannot list the folder");
    while (const dirent* file = ::readdir(listing)) {
        const std::string name = file->d_name;
        const bool is_id =
            name.size() == 32 && name.find_first_not_of("0123456789abcdef") == std::string::npos;
        if (is_id) entries_[name].is_closed = false;
    }
    ::closedir(listing);
}

// Looks at entries that have been let go since: what they hold, and since when.
void Store::note_closed() {
    for (auto& [id, known] : entries_) {
        if (known.is_closed || !known.open.expired()) continue;
        known.is_closed = true;
        known.allocated = 0;
        struct stat status = {};
        for (const char* part : kParts)
            if (::fstatat(folder_.get(), (id + "/" + part).c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0)
                known.allocated += uint64_t(status.st_blocks) * 512;
        // The folder is touched when it is opened.
        if (::fstatat(folder_.get(), id.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0)
            known.last_used = int64_t(status.st_mtim.tv_sec);
    }
}

std::shared_ptr<Entry> Store::find(const std::string& url) {
    const std::string id = id_of(url);
    const auto known = entries_.find(id);
    if (known == entries_.end()) return nullptr;
    if (std::shared_ptr<Entry> open = known->second.open.lock()) return open;
    const Descriptor folder(
        ::openat(folder_.get(), id.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    const std::optional<StoredFacts> stored = folder ? read_facts(folder.get()) : std::nullopt;
    if (stored && stored->facts.url == url) {
        try {
            const std::shared_ptr<Entry> entry(new Entry);
            entry->facts_ = stored->facts;
            entry->block_bytes_ = stored->block_bytes;
            entry->open_parts(folder.get(), path_ + "/" + id);
            ::futimens(folder.get(), nullptr);
            known->second.open = entry;
            known->second.is_closed = false;
            return entry;
        } catch (const core::Error&) {
            // What cannot be opened or does not fit together is fetched anew.
        }
    }
    forget(id);
    return nullptr;
}

std::shared_ptr<Entry> Store::create(const FileFacts& facts) {
    if (facts.bytes == 0 || facts.bytes > kMostFileBytes)
        throw core::Error(core::text("a file of %llu bytes cannot be cached; 1 byte to 1024 GiB can",
                                     static_cast<unsigned long long>(facts.bytes)));
    const std::string id = id_of(facts.url);
    forget(id);
    const std::string name = path_ + "/" + kUnfinished;
    remove_entry_folder(folder_.get(), kUnfinished);
    if (::mkdirat(folder_.get(), kUnfinished, 0700) != 0) fail_with_errno(name, "cannot make the folder");
    const Descriptor folder(::openat(folder_.get(), kUnfinished, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder) fail_with_errno(name, "cannot open the folder");
    try {
        const uint64_t blocks = blocks_in(facts.bytes, kBlockBytes);
        make_sparse_part(folder.get(), "data", facts.bytes, name + "/data");
        make_sparse_part(folder.get(), "sums", blocks * sizeof(uint64_t), name + "/sums");
        make_full_part(folder.get(), "use", use_bytes(facts.bytes), name + "/use");
        const Descriptor map = make_full_part(folder.get(), "map", map_bytes(blocks), name + "/map");
        MapHeader header = {};
        std::memcpy(header.magic, kMagic, sizeof kMagic);
        header.version = kMapVersion;
        header.block_bytes = kBlockBytes;
        header.file_bytes = facts.bytes;
        write_at(map.get(), &header, sizeof header, 0, name + "/map");
        const Descriptor file = make_part(folder.get(), "facts", name + "/facts");
        const std::string text =
            to_json(facts, kBlockBytes).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
        write_at(file.get(), text.data(), text.size(), 0, name + "/facts");
        if (::renameat(folder_.get(), kUnfinished, folder_.get(), id.c_str()) != 0)
            fail_with_errno(name, "cannot rename the folder");
    } catch (const core::Error&) {
        remove_entry_folder(folder_.get(), kUnfinished);
        throw;
    }
    const std::shared_ptr<Entry> entry(new Entry);
    entry->facts_ = facts;
    entry->open_parts(folder.get(), path_ + "/" + id);
    Known& known = entries_[id];
    known.open = entry;
    known.is_closed = false;
    return entry;
}

void Store::remove(const std::string& url) {
    forget(id_of(url));
}

void Store::forget(const std::string& id) {
    if (entries_.erase(id) == 0) return;
    // In one step, so that a kill leaves a whole entry or none.
    ::renameat(folder_.get(), id.c_str(), folder_.get(), kLeaving);
    remove_entry_folder(folder_.get(), kLeaving);
}

uint64_t Store::held_bytes() {
    note_closed();
    uint64_t held = 0;
    for (const auto& [id, known] : entries_) {
        const std::shared_ptr<Entry> open = known.open.lock();
        held += open ? open->allocated_ : known.allocated;
    }
    return held;
}

bool Store::make_room(uint64_t bytes) {
    if (bytes > limit_bytes_) return false;
    if (held_bytes() + bytes <= limit_bytes_) return true;
    // More than is asked for, so that the search is rare.
    const uint64_t spare = std::min<uint64_t>(limit_bytes_ / 16, 64 << 20);
    shrink_to(limit_bytes_ - std::min(limit_bytes_, bytes + spare));
    return held_bytes() + bytes <= limit_bytes_;
}

void Store::shrink_to(uint64_t bytes) {
    evict_closed(bytes);
    if (held_bytes() > bytes) evict_chunks(bytes);
}

void Store::evict_closed(uint64_t bytes) {
    uint64_t held = held_bytes();
    std::vector<std::pair<int64_t, std::string>> closed;
    for (const auto& [id, known] : entries_)
        if (known.is_closed) closed.emplace_back(known.last_used, id);
    std::sort(closed.begin(), closed.end());
    for (const auto& [last_used, id] : closed) {
        if (held <= bytes) return;
        const uint64_t freed = entries_[id].allocated;
        forget(id);
        evicted_bytes_ += freed;
        held -= freed;
    }
}

void Store::evict_chunks(uint64_t bytes) {
    std::vector<Chunk> chunks;
    for (const auto& [id, known] : entries_) {
        const std::shared_ptr<Entry> entry = known.open.lock();
        if (!entry) continue;
        std::vector<uint32_t> uses(use_bytes(entry->facts().bytes) / sizeof(uint32_t));
        if (!read_at(entry->use_.get(), uses.data(), uses.size() * sizeof(uint32_t), 0)) continue;
        for (uint32_t i = 0; i != uses.size(); ++i)
            if (!is_recent(uses[i])) chunks.push_back({entry, i, uses[i]});
    }
    // Times of before the last start of the system may lie ahead, and are older than all others.
    const auto age_rank = [now = use_clock()](const Chunk& chunk) {
        return chunk.last_use > now ? 0 : chunk.last_use;
    };
    std::stable_sort(chunks.begin(), chunks.end(),
                     [&](const Chunk& a, const Chunk& b) { return age_rank(a) < age_rank(b); });
    uint64_t held = held_bytes();
    for (const Chunk& chunk : chunks) {
        if (held <= bytes) return;
        const uint64_t before = chunk.entry->allocated_;
        if (!evict(chunk)) continue;
        const uint64_t freed = before - std::min(before, chunk.entry->allocated_);
        evicted_bytes_ += freed;
        held -= std::min(held, freed);
    }
}

// False where a block is on its way, or a client reads the chunk after all.
bool Store::evict(const Chunk& chunk) {
    Entry& entry = *chunk.entry;
    const uint32_t a_chunk = kChunkBytes / entry.block_bytes();
    const uint32_t begin = chunk.index * a_chunk, end = std::min(begin + a_chunk, entry.block_count());
    std::vector<uint32_t> present;
    for (uint32_t block = begin; block != end; ++block) {
        if (entry.state(block) == BlockState::requested) return false;
        if (entry.state(block) == BlockState::present) present.push_back(block);
    }
    if (present.empty()) return false;
    for (const uint32_t block : present) entry.set_state(block, BlockState::absent);
    uint32_t use = 0;
    std::atomic_thread_fence(std::memory_order_seq_cst);
    const bool is_known = read_at(entry.use_.get(), &use, sizeof use, chunk.index * sizeof use);
    if (is_known && is_recent(use)) {
        for (const uint32_t block : present) entry.set_state(block, BlockState::present);
        return false;
    }
    entry.present_count_ -= present.size();
    ::fallocate(entry.data_.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                off_t(chunk.index) * kChunkBytes, kChunkBytes);
    entry.note_allocated();
    return true;
}

}  // namespace fetch
