// The cache on disk: for each URL a sparse file of the blocks that came, and what is known about it.
//
// **A block is marked present only when its bytes are there and match.**  `kill -9` at any instant loses at
// most the blocks in flight.  Why this holds:
//
//   - put() writes the bytes, then their checksums, then marks the blocks present, in this order and by one
//     thread.  What a process has written is in the system's page cache and outlives it, however it ends.  So
//     after a kill the mark implies the bytes.
//   - The page cache does not outlive the system, which may have put the mark on disk, and not the bytes.  So
//     the map names the boot under which it was written.  Under another one, open() compares each block that
//     is marked with its checksum, forgets those that differ, and only then names the new boot.
//   - Nothing is overwritten in place by other bytes: a file that has changed at the server gets an entry of
//     its own.
//   - An entry is made in a folder of another name and renamed when it is whole; one without all of its
//     parts, or whose parts do not fit together, is removed when it is met.
//   - The map is allocated when it is made, so that a full disk shows in a write(), never in a store to a
//     map.
//
// An entry is a folder, named by a hash of the URL, of:
//   data   the file's bytes at their places; holes where nothing has come
//   sums   8 bytes a block, XXH3 of its bytes; its place is that of the block's number
//   map    which blocks are there, block_map.h        use    when each chunk was last read, block_map.h
//   facts  JSON: url, bytes, block_bytes, etag, last_modified; modified when the server last confirmed them
//
// One thread, one process (the folder is locked); clients read the data and the map at the same time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fetch/block_map.h"
#include "fetch/descriptor.h"

namespace fetch {

// What tells two versions of a file apart; as the server sent them, empty if it did not.
struct Validator {
    std::string etag, last_modified;
    bool operator==(const Validator&) const = default;
};

struct FileFacts {
    std::string url;
    uint64_t bytes = 0;  // 1 to kMostFileBytes
    Validator validator;
};

// A cached file that is open.  Lives on, through its descriptors, when its folder is removed.
class Entry {
  public:
    const FileFacts& facts() const { return facts_; }
    uint32_t block_bytes() const { return block_bytes_; }
    uint32_t block_count() const { return uint32_t(blocks_in(facts_.bytes, block_bytes_)); }
    // The last block may be shorter than the others.
    uint32_t size_of(uint32_t block) const;

    BlockState state(uint32_t block) const { return states_.get(block); }
    // Of a block that is not present, to another state than present.
    void set_state(uint32_t block, BlockState state) { states_.set(block, state); }
    // Takes the bytes of whole blocks, from block `first` on, and marks them present, and in use now.  Throws
    // core::Error where they cannot be written (DiskFull for want of space); the blocks stay as they were.
    void put(uint32_t first, std::span<const std::byte> bytes);
    uint64_t present_count() const { return present_count_; }

    // When the server last said that this is its version, seconds of the system's clock, which may have been
    // set since.
    int64_t confirmed_at() const { return confirmed_at_; }
    void confirm();

    // The clients' map says from now on that the server has another version.
    void mark_replaced();

    // For clients: data and availability map can be read only, the use map written too.
    int data_for_clients() const { return data_for_clients_.get(); }
    int map_for_clients() const { return map_for_clients_.get(); }
    int use_for_clients() const { return use_.get(); }

  private:
    friend class Store;
    Entry() = default;
    void open_parts(int folder, const std::string& name);
    void check_blocks();
    void note_use(uint32_t first, uint32_t last);
    void note_allocated();

    FileFacts facts_;
    std::string name_;  // for messages
    uint32_t block_bytes_ = kBlockBytes;
    Descriptor data_, sums_, map_file_, use_, facts_file_, data_for_clients_, map_for_clients_;
    FileMap map_;
    BlockStates states_;
    uint64_t present_count_ = 0;
    uint64_t allocated_ = 0;  // bytes on disk
    uint32_t noted_chunk_ = 0, noted_use_ = 0;
    int64_t confirmed_at_ = 0;
};

class Store {
  public:
    // Opens the cache in the private folder `path`, which is made if it is missing, and locks it.  Holds at
    // most `limit_bytes` of disk space.  Throws core::Error as private_folder.h says, and where the file
    // system cannot punch holes.
    Store(const std::string& path, uint64_t limit_bytes);
    ~Store();

    // The entry of a URL, opened, or null.  An entry that is damaged is removed, and null.
    std::shared_ptr<Entry> find(const std::string& url);
    // Makes the entry of a URL anew; one that was there is removed as by remove().  Throws core::Error.
    std::shared_ptr<Entry> create(const FileFacts& facts);
    // Who holds the entry keeps it; the next find() does not.  Nothing where there is none.
    void remove(const std::string& url);

    // Makes room for so many bytes more within the limit: entries that nobody holds go first, the longest
    // unused first, then chunks of the others that no client has read for kGraceSeconds.  False where that is
    // not enough.
    bool make_room(uint64_t bytes);
    // Gives back disk space until at most `bytes` are held, as far as nobody reads them.
    void shrink_to(uint64_t bytes);

    uint64_t held_bytes();  // as allocated on disk by the entries that find() finds
    uint64_t evicted_bytes() const { return evicted_bytes_; }
    uint64_t limit_bytes() const { return limit_bytes_; }
    size_t entry_count() const { return entries_.size(); }
    int folder() const { return folder_.get(); }
    const std::string& path() const { return path_; }

  private:
    struct Known {
        std::weak_ptr<Entry> open;
        bool is_closed = true;   // then the other two are known
        uint64_t allocated = 0;  // bytes
        int64_t last_used = 0;   // when it was closed, seconds of the system's clock; for order only
    };
    struct Chunk;

    void scan();
    void forget(const std::string& id);
    void note_closed();
    void evict_closed(uint64_t bytes);
    void evict_chunks(uint64_t bytes);
    bool evict(const Chunk& chunk);

    std::string path_;
    uint64_t limit_bytes_;
    Descriptor folder_, lock_;
    std::map<std::string, Known> entries_;  // by the name of their folder
    uint64_t room_ = 0;                     // what make_room() may give without counting again
    uint64_t evicted_bytes_ = 0;
};

// The name of a URL's folder: 32 hexadecimal digits.
std::string id_of(const std::string& url);

}  // namespace fetch
