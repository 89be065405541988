// The corpus as a test: no seed, and nothing that a fuzzer once found, breaks a promise.
#include "seeds.hpp"
#include "targets.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace {

std::vector<std::filesystem::path> corpus_of(std::string_view target) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(CAMBER_TEST_DIR) / "corpus" / target))
        files.push_back(entry.path());
    return files;
}

std::string content(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void run(const fuzz::Target& target, const std::string& bytes) { target.run(std::as_bytes(std::span(bytes))); }

}  // namespace

TEST_CASE("every target holds its promises on its corpus") {
    for (const fuzz::Target& target : fuzz::targets) {
        const auto files = corpus_of(target.name);
        CHECK_MESSAGE(!files.empty(), target.name);
        for (const auto& file : files) {
            INFO(file.string());  // a broken promise ends the process: doctest tells the case, the promise is on stderr
            run(target, content(file));
        }
    }
}

TEST_CASE("and on whatever is left when a seed is cut or a byte of it is another") {
    for (const fuzz::Seed& seed : fuzz::seeds()) {
        const fuzz::Target* target = nullptr;
        for (const fuzz::Target& t : fuzz::targets)
            if (t.name == seed.target) target = &t;
        REQUIRE(target != nullptr);
        const std::size_t step = 1 + seed.bytes.size() / 64;
        for (std::size_t n = 0; n < seed.bytes.size(); n += step) {
            run(*target, seed.bytes.substr(0, n));
            std::string other = seed.bytes;
            other[n] = static_cast<char>(other[n] ^ 0x55);
            run(*target, other);
        }
    }
}
