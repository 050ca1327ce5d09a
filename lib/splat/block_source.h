// Where the bytes of a model come from that is still arriving.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace splat {

// A file of known size, of which some bytes are there.  What is there stays the same; more may come at any
// time, and what is not looked at may go.
class BlockSource {
  public:
    virtual ~BlockSource() = default;

    virtual std::string name() const = 0;  // for messages
    virtual uint64_t file_bytes() const = 0;
    // The file's first byte; only those may be read that has() found.
    virtual const std::byte* data() const = 0;
    // Whether these bytes, within the file, are all there.  If so they stay for 10 seconds at least, and
    // longer if they are looked at again.  From any thread.
    virtual bool has(uint64_t offset, uint64_t size) const = 0;
};

}  // namespace splat
