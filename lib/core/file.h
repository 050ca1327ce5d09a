// Files: reading whole inputs by mapping, and writing outputs that appear whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
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
    InputFile(int fd, std::string name);

    struct State;
    std::unique_ptr<State> state_;
    std::span<const std::byte> bytes_;
    std::string name_;
};

// Thrown where a pipe's reader has gone.  Not an Error, and no std::exception, so that nothing
// but Program::run() catches it, which ends the program quietly with status 0.
struct ClosedPipe {};

// A file that is written beside its target under a temporary name and renamed by commit();
// "-" is standard output, where commit() only flushes.  Destroyed without commit(), or at
// SIGINT/SIGTERM/SIGHUP, it leaves nothing behind.  An existing non-regular target (a FIFO,
// /dev/null) is written in place; a symbolic link is followed.  At most 64 are open at a time.
// One thread at a time may use one object.  Throws Error with the system's reason (disk full,
// ...), and ClosedPipe where the reader of a pipe has gone.
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

// True if both names exist and are one file (device and inode).  "-" is nobody's equal.
bool same_file(const std::string& a, const std::string& b);

// What is lost when something else is written to `path`: the file's full name, after links, whether or not it
// exists yet.  Equal for two outputs of which one would overwrite the other.  Empty for "" and "-", and for a
// character device such as /dev/null, which keeps nothing.
std::string overwritten_file(const std::string& path);

// Throws UsageError where `path` is "-" or absent-by-default, standard output is a terminal and
// the user did not spell out "-": binary is never written to a terminal unasked.
void refuse_binary_to_terminal(bool spelled_out);

}  // namespace core
