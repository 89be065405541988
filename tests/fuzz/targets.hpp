// Fuzz targets. Each target accepts arbitrary bytes and aborts if an expectation fails. The fuzzer itself detects
// crashes, hangs and memory allocated for a false count in a header. `entry.cpp` builds a libFuzzer program of one
// target; `replay.cpp` runs all targets on the corpus as an ordinary test.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace fuzz {

using Bytes = std::span<const std::byte>;

/// `decode_mesh` for all formats except CGNS, which an external library reads. Accepted meshes are consistent, survive
/// writing and reading, and can be examined and validated.
void mesh(Bytes bytes);
/// `decode_gmf_solution`. Accepted solutions survive writing and reading.
void solution(Bytes bytes);
/// `read_pipeline` with settings (lines before the first `{`), `read_metric` and `read_geometry`. Accepted configs
/// survive writing and reading.
void config(Bytes bytes);
/// `histograms_of_report`. Accepted histograms can be drawn.
void report(Bytes bytes);
/// Metric expressions: a value at every point, or an error.
void expression(Bytes bytes);

struct Target {
    std::string_view name;
    void (*run)(Bytes);
};
inline constexpr std::array<Target, 5> targets{
    {{"mesh", mesh}, {"solution", solution}, {"config", config}, {"report", report}, {"expression", expression}}};

/// Ends the process and prints the failed expectation if `holds` is false.
void expect(bool holds, std::string_view expectation);

}  // namespace fuzz
