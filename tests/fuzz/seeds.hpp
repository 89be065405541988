// What fuzzing begins with, made by Camber's own encoders: `fuzz_seeds DIRECTORY` writes them.
#pragma once

#include <string>
#include <vector>

namespace fuzz {

struct Seed {
    std::string target, name, bytes;
};

[[nodiscard]] std::vector<Seed> seeds();

}  // namespace fuzz
