// The small meshes of tests/data, and tests named after the files that they read.
#pragma once

#include <algorithm>
#include <string>

inline const std::string kData = QS_TEST_DATA "/";

// The name of a test about `file`: GoogleTest allows letters, digits and underscores.
inline std::string test_name_of(std::string file) {
    std::replace_if(
        file.begin(), file.end(), [](char c) { return c == '-' || c == '.' || c == '/'; }, '_');
    return file;
}
