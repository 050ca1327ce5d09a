// A search for inputs that a fuzz target does not bear, for builds without libFuzzer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "mutations.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace fuzz {

// A copy of exactly the right size, so that reading past its end shows under a sanitizer.
void run(const Bytes& bytes);

struct Search {
    std::vector<Bytes> seeds;
    std::filesystem::path kept;  // inputs that reached code which none before did are written here
    std::string failures;        // begins the names of files with inputs that the target did not bear
    double seconds = 0;
    uint64_t seed = 1;
};

// Mutates seeds, and what is found new, for `seconds`, in a process of its own: one that dies, or that takes
// longer than 20 s for one input, leaves that input in a file.  Prints one line; true if the target bore
// everything.
//
// What is new is told by the compiler's -fsanitize-coverage=trace-pc (QS_FUZZ with g++).  Without it nothing
// is new and only the seeds are mutated.
bool search(const Search& search);

}  // namespace fuzz
