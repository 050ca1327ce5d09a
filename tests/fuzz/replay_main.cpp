// Runs a fuzz target without libFuzzer: every file of a folder as it is, then a bounded number of mutations
// of each, the same in every run.  Or, as libFuzzer is asked to, searches for a time:
//
//     replay SEEDS
//     replay -max_total_time=SECONDS -seed=N -artifact_prefix=PREFIX KEPT SEEDS
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string_view>

#include "search.h"

namespace {

using fuzz::Bytes;

constexpr int kMutations = 300;  // of each file: seconds for a corpus, with sanitizers too

Bytes read_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<Bytes> read_folders(const std::vector<std::filesystem::path>& folders) {
    std::vector<std::filesystem::path> paths;
    for (const auto& folder : folders)
        for (const auto& entry : std::filesystem::directory_iterator(folder)) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<Bytes> files;
    for (const auto& path : paths) files.push_back(read_file(path));
    return files;
}

void replay(const std::vector<Bytes>& seeds) {
    fuzz::run({});
    for (const Bytes& seed : seeds) {
        fuzz::run(seed);
        std::mt19937_64 random(1);
        for (int n = 0; n < kMutations; ++n) fuzz::run(fuzz::mutated(seed, random));
    }
    std::printf("%zu files, %d mutations of each\n", seeds.size(), kMutations);
}

// "-name=value": the value where `argument` begins so.
const char* value_of(std::string_view name, const char* argument) {
    return std::string_view(argument).starts_with(name) ? argument + name.size() : nullptr;
}

}  // namespace

int main(int argc, char** argv) {
    fuzz::Search search;
    std::vector<std::filesystem::path> folders;
    for (int i = 1; i < argc; ++i) {
        if (const char* seconds = value_of("-max_total_time=", argv[i]))
            search.seconds = std::strtod(seconds, nullptr);
        else if (const char* seed = value_of("-seed=", argv[i]))
            search.seed = std::strtoull(seed, nullptr, 10);
        else if (const char* prefix = value_of("-artifact_prefix=", argv[i]))
            search.failures = prefix;
        else
            folders.emplace_back(argv[i]);
    }
    const bool searches = search.seconds > 0;
    if (folders.size() != (searches ? 2 : 1)) {
        std::fputs(
            "usage: replay SEEDS\n       replay -max_total_time=SECONDS -seed=N -artifact_prefix=PREFIX KEPT "
            "SEEDS\n",
            stderr);
        return 2;
    }
    search.seeds = read_folders(folders);
    if (search.seeds.empty()) {
        std::fprintf(stderr, "replay: %s: the corpus is empty\n", folders.back().c_str());
        return 1;
    }
    if (!searches) {
        replay(search.seeds);
        return 0;
    }
    search.kept = folders.front();
    return fuzz::search(search) ? 0 : 1;
}
