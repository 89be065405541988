// Runs all fuzz targets on the corpus as an ordinary test.
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

TEST_CASE("every fuzz target accepts all files of its corpus") {
    for (const fuzz::Target& target : fuzz::targets) {
        const auto files = corpus_of(target.name);
        CHECK_MESSAGE(!files.empty(), target.name);
        for (const auto& file : files) {
            INFO(file.string());  // a failed expectation ends the process: doctest prints the file, stderr the
                                  // expectation
            run(target, content(file));
        }
    }
}

TEST_CASE("every fuzz target accepts truncated seeds and seeds with a changed byte") {
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
