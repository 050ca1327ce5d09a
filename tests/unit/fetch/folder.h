// A fresh folder of a test, removed with it, and bytes to put into it.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace fetch_test {

class Folder {
  public:
    explicit Folder(const std::filesystem::path& above = std::filesystem::temp_directory_path()) {
        std::string name = (above / "qs-fetch-XXXXXX").string();
        if (!::mkdtemp(name.data())) std::abort();
        path = name;
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::string path;
};

inline std::vector<std::byte> random_bytes(size_t size, uint64_t seed = 1) {
    std::mt19937_64 random(seed);
    std::vector<std::byte> bytes(size);
    for (std::byte& b : bytes) b = std::byte(random());
    return bytes;
}

}  // namespace fetch_test
