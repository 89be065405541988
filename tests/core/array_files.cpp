// Arrays that lie in files: what is in them stays there, whoever has the memory.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <numeric>
#include <span>
#include <string>
#include <vector>

import camber.core;

using namespace camber;

TEST_CASE("arrays in files keep what is written, and are made in memory again when asked") {
    const std::string folder = std::filesystem::temp_directory_path().string();
    CHECK(keep_arrays_in_files(folder + "/nowhere/at-all") != 0);
    if (const int error = keep_arrays_in_files(folder); error != 0) {
        MESSAGE("no files without a name can be made in ", folder, ": error ", error);
        return;
    }
    constexpr std::size_t n = std::size_t{1} << 17U;
    std::vector<double> given(n);
    std::iota(given.begin(), given.end(), 0.5);
    {
        Buffer<double> array(n);
        CHECK(bytes_in_files() == n * sizeof(double));
        fill_array<double>(array, given);
        array[7] = -1;
        fill_array<double>(std::span(array).subspan(n / 2), std::span(given).first(n / 2));
        give_back_arrays();
        CHECK(array[7] == -1);
        CHECK(array[8] == given[8]);
        CHECK(array[n / 2] == given[0]);
        CHECK(array[n - 1] == given[n / 2 - 1]);
        CHECK(keep_arrays_in_files("") == 0);
        Buffer<double> in_memory(n);
        CHECK(bytes_in_files() == n * sizeof(double));
        fill_array<double>(in_memory, given);
        CHECK(std::ranges::equal(in_memory, given));
    }
    CHECK(bytes_in_files() == 0);
}
