// Reading bytes of a remote file in turn, as far ahead as keeps the link busy.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "fetch/client.h"

namespace fetch {

// Hands the bytes from `first` to `last` (both included, within the file) to `take`, in order.  Throws
// core::Error, in which `url` is named, where the file ends before (it has changed, the server refuses), and
// where nothing comes for `timeout_s`.
void read_range(Connection& connection, RemoteFile& file, const std::string& url, uint64_t first,
                uint64_t last, double timeout_s, const std::function<void(std::span<const std::byte>)>& take);

}  // namespace fetch
