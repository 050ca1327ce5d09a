// What a program needs to read files at HTTP servers through the daemon.
//
//     fetch::Connection connection({.folder = fetch::default_folder()});
//     const auto file = connection.open("http://example.org/model.qs");
//     file->want(wants);                          // as often as wanted, takes the place of the earlier ones
//     if (connection.wait(0.02)) ...              // something has come
//     std::span<const std::byte> bytes = file->block(7);   // empty: not there
//
// A block that is there costs no system call: data and availability are maps of the daemon's files.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fetch/block_map.h"
#include "fetch/descriptor.h"
#include "fetch/messages.h"

namespace fetch {

class Connection;

// A file that is open, of one version: what block() gives is never of another.
class RemoteFile {
  public:
    ~RemoteFile();
    RemoteFile(const RemoteFile&) = delete;
    RemoteFile& operator=(const RemoteFile&) = delete;

    uint64_t bytes() const { return bytes_; }
    uint32_t block_bytes() const { return block_bytes_; }
    uint32_t block_count() const { return uint32_t(blocks_in(bytes_, block_bytes_)); }

    // The bytes of a block below block_count(), empty where it is not there.  They stay for kGraceSeconds at
    // least, and for as much longer as the block is asked for again.  From any thread.
    std::span<const std::byte> block(uint32_t index) const;

    // Takes the place of all earlier wants; of more than kMostWants those of the highest priority count.
    // Never waits: where the daemon does not keep up it returns false, and the earlier wants hold.  Throws
    // core::Error where the daemon has gone.
    bool want(std::vector<Want> wants);

    // The server has another version: what is here stays, nothing more comes; open() gives the other one.
    bool is_replaced() const { return is_replaced_; }
    // Why nothing more comes; empty where more may come.
    const std::string& failure() const { return failure_; }
    // What is to be known about the version that was opened: that it took the place of a cached one, or that
    // the server could not be asked; empty where neither.
    const std::string& note() const { return note_; }
    // What is being tried again; empty where a block has come since it was told.
    const std::string& trouble() const { return trouble_; }

  private:
    friend class Connection;
    RemoteFile(Connection& connection, uint32_t stream) : connection_(connection), stream_(stream) {}
    void take_opened(const Reply& reply, std::vector<Descriptor>& descriptors);

    Connection& connection_;
    uint32_t stream_;
    bool is_open_ = false, is_replaced_ = false;
    uint64_t bytes_ = 0;
    uint32_t block_bytes_ = kBlockBytes;
    FileMap data_, map_, use_;
    BlockStates states_;
    std::string failure_, trouble_, note_;
};

struct ClientOptions {
    std::string folder;   // of the cache
    std::string program;  // that is started as "PROGRAM serve" where no daemon runs; empty: none is
    std::vector<std::string> daemon_arguments;  // more for it
    double start_timeout_s = 10;
};

// Not thread-safe, nor are its files but for block().  It outlives them.
class Connection {
  public:
    // Throws core::Error where no daemon runs and none can be started.
    explicit Connection(const ClientOptions& options);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    // Waits for the first answer of the server, or for what is in the cache.  Throws core::Error with the
    // reason.
    std::unique_ptr<RemoteFile> open(const std::string& url, double timeout_s = 60);

    // Waits until something has come, to be seen by the files: a wanted block, an end, a trouble.  False
    // where nothing has in this time.  Throws core::Error where the daemon has gone.
    bool wait(double timeout_s);
    int descriptor() const { return socket_.get(); }  // readable when wait(0) would find something

    // The daemon's counters, JSON as in qs-fetch(1).
    std::string status();
    // Lets go of all but `keep_bytes`, or of one URL.
    std::string evict(uint64_t keep_bytes, const std::string& url);
    void stop();

  private:
    friend class RemoteFile;
    void connect(const ClientOptions& options);
    bool send(const Request& request);
    void send_surely(const Request& request);
    bool take_messages();
    void take(const Reply& reply, std::vector<Descriptor>& descriptors);
    std::string ask(const Request& request);

    std::string folder_;
    Descriptor socket_;
    uint32_t next_stream_ = 1;
    std::map<uint32_t, RemoteFile*> files_;
    bool has_answer_ = false;
    Reply answer_;
};

}  // namespace fetch
