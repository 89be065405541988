// What is fuzzed: each target takes any bytes, and aborts when a promise is broken (crashes, hangs, and memory asked
// for on a header's word are seen by the fuzzer itself). `entry.cpp` makes a libFuzzer program of one; `replay.cpp`
// runs all of them over the corpus as an ordinary test.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace fuzz {

using Bytes = std::span<const std::byte>;

/// decode_mesh, all formats but CGNS, whose library reads: what is accepted is consistent, survives writing and
/// reading, and can be examined and judged.
void mesh(Bytes bytes);
/// decode_gmf_solution: what is accepted survives writing and reading.
void solution(Bytes bytes);
/// read_pipeline with settings (lines before the first `{`), read_metric and read_geometry: what is accepted survives
/// writing and reading.
void config(Bytes bytes);
/// histograms_of_report: what is accepted can be drawn.
void report(Bytes bytes);
/// Expressions of metrics: a value at every point, or an error.
void expression(Bytes bytes);

struct Target {
    std::string_view name;
    void (*run)(Bytes);
};
inline constexpr std::array<Target, 5> targets{
    {{"mesh", mesh}, {"solution", solution}, {"config", config}, {"report", report}, {"expression", expression}}};

/// Ends the process, with the promise that was broken.
void expect(bool holds, std::string_view promise);

}  // namespace fuzz
