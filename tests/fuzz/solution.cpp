#include "targets.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

import camber.core;
import camber.io;

namespace fuzz {

namespace {

using namespace camber;

const Execution one_thread{.threads = 1};

void expect_survival(const Solution& solution, GmfEncoding encoding) {
    const auto written = encode_gmf_solution(solution, {encoding, 0}, one_thread);
    expect(written.has_value(), "decoded input can be encoded");
    std::vector<std::byte> bytes;
    for (const auto& chunk : *written) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    auto again = decode_gmf_solution(bytes, "again", one_thread);
    expect(again.has_value(), "encoded output can be decoded");
    again->solution.single_precision = solution.single_precision;  // encoders write 8 bytes
    expect(again->solution == solution, "the solution is the same");
}

}  // namespace

void solution(Bytes bytes) {
    const auto decoded = decode_gmf_solution(bytes, "file", one_thread);
    if (!decoded) {
        expect(!decoded.error().what.empty(), "an error has a description");
        expect(decoded.error().where.starts_with("file"), "an error states its place");
        return;
    }
    expect(format_with_content(solution_formats(), bytes) != nullptr,
           "the content of decoded input identifies its format");
    const Solution& s = decoded->solution;
    expect(!s.fields.empty(), "a solution has fields");
    expect(s.values.size() == s.rows * row_width(s), "as many values as the fields of the rows have");
    for (const double x : s.values) expect(std::isfinite(x), "values are finite");
    expect_survival(s, GmfEncoding::binary);
    expect_survival(s, GmfEncoding::ascii);
}

}  // namespace fuzz
