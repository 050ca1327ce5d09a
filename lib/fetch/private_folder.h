// A folder that belongs to one user and is used by one process at a time.
#pragma once

#include <string>

#include "fetch/descriptor.h"

namespace fetch {

// Makes `path` and what is missing above it, open to nobody else (0700), and opens it.  Throws core::Error
// where it cannot be made, is no folder, or belongs, or is open, to others.
Descriptor open_private_folder(const std::string& path);

// A file in the folder that this process alone holds locked; closing it lets go.  Throws core::Error where
// another process holds it, naming that one.
Descriptor lock_folder(int folder, const std::string& path);

// $XDG_CACHE_HOME/qs-fetch, or ~/.cache/qs-fetch.  Throws core::Error where neither is set.
std::string default_folder();

}  // namespace fetch
