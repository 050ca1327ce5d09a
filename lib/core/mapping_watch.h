// What is read of a mapped file behind its end, when another program has made it shorter, is a signal.  Where
// it is one of a watched file, the program ends as at any other error: with a line that names the file, and
// exit status 1.
#pragma once

#include <cstddef>
#include <string>

namespace core {

// Before it ends the program the handler calls `tidy`, which keeps to what handlers may do.
void watch_mapping(const std::byte* data, size_t size, const std::string& name, void (*tidy)());
void forget_mapping(const std::byte* data);

}  // namespace core
