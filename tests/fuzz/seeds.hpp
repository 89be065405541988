// Initial corpus of the fuzzers, made by Camber's encoders. `fuzz_seeds DIRECTORY` writes it.
#pragma once

#include <string>
#include <vector>

namespace fuzz {

struct Seed {
    std::string target, name, bytes;
};

[[nodiscard]] std::vector<Seed> seeds();

}  // namespace fuzz
