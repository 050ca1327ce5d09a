// Files: reading whole inputs by mapping, and writing outputs that appear whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace core {

// The bytes of a file, mapped read-only; of a pipe or "-" (standard input), read into
// memory to its end.  Move-only; the span lives as long as the object.  Threads may share it.
// A regular file that shrinks while it is mapped ends the program by SIGBUS, as with any map.
// Throws Error: cannot open, is a directory, cannot read.
class InputFile {
  public:
    explicit InputFile(const std::string& path);
    // How many bytes there can be at most, told from the first 4 KiB, or all where there are fewer.  Throws
    // Error for what is none of the caller's files.
    using SizeLimit = std::function<uint64_t(std::span<const std::byte> head, const std::string& name)>;
    // A pipe is read little further than that, so that an endless one ends.
    InputFile(const std::string& path, const SizeLimit& limit);
    ~InputFile();
    InputFile(InputFile&&) noexcept;
    InputFile& operator=(InputFile&&) noexcept;

    std::span<const std::byte> bytes() const { return bytes_; }
    const std::string& name() const { return name_; }  // for messages; "standard input" for "-"

    // Tells the system that the map's bytes [begin, end) will not be needed again (memory
    // cap of builders).  Does nothing for piped input.
    void forget(size_t begin, size_t end) const;

  private:
    friend class OutputFile;
    InputFile(int fd, std::string name, const SizeLimit& limit = {});

    struct State;
    std::unique_ptr<State> state_;
    std::span<const std::byte> bytes_;
    std::string name_;
};

// Thrown where a pipe's reader has gone and nothing else is being written: no OutputFile is left whose reader
// has not gone, and no OutputsToCome.  Not an Error, and no std::exception, so that nothing but
// Program::run() catches it, which ends the program quietly with status 0.
struct ClosedPipe {};

// While one lives, files are to be written that are not open yet.  Any thread.
class OutputsToCome {
  public:
    OutputsToCome();
    ~OutputsToCome();
    OutputsToCome(const OutputsToCome&) = delete;
    OutputsToCome& operator=(const OutputsToCome&) = delete;
};

// A file that is written beside its target under a temporary name and renamed by commit();
// "-" is standard output, where commit() only flushes.  Destroyed without commit(), or at
// SIGINT/SIGTERM/SIGHUP, it leaves nothing behind.  An existing non-regular target (a FIFO,
// /dev/null) is written in place; a symbolic link is followed.  At most 64 are open at a time.
// Where the reader of a pipe has gone, the rest is dropped, or ClosedPipe thrown where nobody waits for
// anything else.  One thread at a time may use one object.  Throws Error with the system's reason (disk
// full, ...).
class OutputFile {
  public:
    explicit OutputFile(const std::string& path);
    // A file in memory that nobody else sees, to be read back; `name` is for messages.
    struct InMemory {
        std::string name;
    };
    explicit OutputFile(const InMemory& file);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(std::span<const std::byte> data);
    void write(std::string_view data);
    void write(const void* data, size_t size) { write({static_cast<const std::byte*>(data), size}); }
    void commit();
    // What was written to a file in memory, instead of commit().
    InputFile read_back();
    const std::string& name() const { return name_; }

  private:
    struct State;
    std::unique_ptr<State> state_;
    std::string name_;
};

// Writes to standard output through the buffer that core::print() shares; flushes if told.
// Throws like OutputFile.
void write_standard_output(std::string_view data, bool flush);

// True if both names exist and are one file (device and inode).  `input` "-" is standard input and `output`
// "-" standard output where these are regular files; nobody's equal where they are pipes or devices.
bool same_file(const std::string& input, const std::string& output);

// What is lost when something else is written to `path`: equal for two outputs of which one would overwrite
// the other, by whatever names, whether or not the file exists yet; "-" is standard output, which has other
// names too (/dev/stdout).  Empty for "", and for a character device such as /dev/null, which keeps nothing.
std::string overwritten_file(const std::string& path);

// Throws UsageError where `path` is "-" or absent-by-default, standard output is a terminal and
// the user did not spell out "-": binary is never written to a terminal unasked.
void refuse_binary_to_terminal(bool spelled_out);

}  // namespace core
