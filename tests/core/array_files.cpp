// Arrays in files keep their content when their memory is released.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <numeric>
#include <span>
#include <string>
#include <vector>

import camber.core;

using namespace camber;

TEST_CASE("arrays in files keep their values, and later arrays can be in memory again") {
    const std::string folder = std::filesystem::temp_directory_path().string();
    CHECK(store_arrays_in_files(folder + "/nowhere/at-all") != 0);
    if (const int error = store_arrays_in_files(folder); error != 0) {
        MESSAGE("no files without a name can be made in ", folder, ": error ", error);
        return;
    }
    constexpr std::size_t n = std::size_t{1} << 17U;
    std::vector<double> input(n);
    std::iota(input.begin(), input.end(), 0.5);
    {
        Buffer<double> array(n);
        CHECK(bytes_in_files() == n * sizeof(double));
        fill_array<double>(array, input);
        array[7] = -1;
        fill_array<double>(std::span(array).subspan(n / 2), std::span(input).first(n / 2));
        release_array_memory();
        CHECK(array[7] == -1);
        CHECK(array[8] == input[8]);
        CHECK(array[n / 2] == input[0]);
        CHECK(array[n - 1] == input[n / 2 - 1]);
        CHECK(store_arrays_in_files("") == 0);
        Buffer<double> in_memory(n);
        CHECK(bytes_in_files() == n * sizeof(double));
        fill_array<double>(in_memory, input);
        CHECK(std::ranges::equal(in_memory, input));
    }
    CHECK(bytes_in_files() == 0);
}

TEST_CASE("an array that exceeds the file size limit is an error, not a signal") {
    const std::string folder = std::filesystem::temp_directory_path().string();
    if (store_arrays_in_files(folder) != 0) return;
    CHECK(store_arrays_in_files("") == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit small{1 << 20, 1 << 20};
        ::setrlimit(RLIMIT_FSIZE, &small);
        std::signal(SIGXFSZ, SIG_IGN);
        bool is_right = store_arrays_in_files(folder) == 0;
        const auto result = guarded([]() -> Outcome<double> {
            Buffer<double> array(std::size_t{1} << 18U);
            array.back() = 1;
            return array.back();
        });
        is_right = is_right && !result && result.error().kind == ErrorKind::write && result.error().where == folder &&
                   result.error().what.find("File too large") != std::string::npos &&
                   result.error().remedy.find("ulimit -f") != std::string::npos && bytes_in_files() == 0;
        ::_exit(is_right ? 0 : 1);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
}
