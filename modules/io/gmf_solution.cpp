module;
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace gmf {

namespace {

Outcome<Solution> read_solution(const File& file, const Block& block, const Execution& execution) {
    Solution solution{.dimension = static_cast<int>(*file.dimension), .single_precision = file.version == 1};
    for (const std::int32_t type : block.fields) {
        if (type < 1 || type > 4)
            return fail_at(file, block.start,
                           "a field of SolAtVertices has type " + std::to_string(type) + ", not 1 to 4");
        solution.fields.push_back(FieldKind{type});
    }
    const std::size_t width = row_width(solution);
    if (auto fits = check_size(file, block, 0, static_cast<int>(width)); !fits) return fail(std::move(fits.error()));
    // Rows have any width: each value is read as a row of its own.
    Block single = block;
    single.count = block.count * width;
    single.rows_per_entity = width;
    Buffer<double> values(single.count);
    auto read = read_rows<ValueRow>(file, single, execution, [&](std::size_t i, const ValueRow& row) {
        values[i] = row.real[0];
        return Fault{std::isfinite(row.real[0]) ? FaultKind::none : FaultKind::not_finite};
    });
    if (!read) return fail(std::move(read.error()));
    solution.rows = block.count;
    solution.values = std::move(values);
    return solution;
}

template <class Sink>
Outcome<Chunks> written(Sink sink, const Solution& solution) {
    std::vector<std::int32_t> header{static_cast<std::int32_t>(solution.fields.size())};
    for (const FieldKind kind : solution.fields) header.push_back(static_cast<std::int32_t>(kind));
    auto done = sink.value(Keyword::dimension, solution.dimension).and_then([&](Done) {
        return sink.solution(solution.rows, header, solution.values.view());
    });
    if (!done) return fail(std::move(done.error()));
    return std::move(sink).finish();
}

Outcome<Chunks> encode(const Solution& solution, GmfOptions options, const Execution& execution) {
    BinarySizer sizer;
    sizer.more(24 + 4 * (solution.fields.size() + 1) + 8 * solution.values.size());
    const bool ascii = options.encoding == GmfEncoding::ascii;
    const auto version = chosen_version(options, ascii ? 2 : sizer.min_version());
    if (!version) return fail(version.error());
    const std::size_t words = solution.values.size();
    if (ascii) return written(AsciiWriter(*version, words, execution), solution);
    if (*version == 4)
        return written(BinaryWriter<Layout<double, std::int64_t, ByteOrder::native>>(4, words, execution), solution);
    return written(BinaryWriter<Layout<double, std::int32_t, ByteOrder::native>>(*version, words, execution), solution);
}

}  // namespace

}  // namespace gmf

Outcome<DecodedSolution> decode_gmf_solution(std::span<const std::byte> bytes, std::string_view name,
                                             const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedSolution> {
        const double of_index = is_gmf_ascii(bytes) ? 0.3 : 0;
        const auto file = gmf::open_file(bytes, name, part_of(execution, 0, of_index));
        if (!file) return fail(file.error());
        const gmf::Block* const block = file->find(gmf::Keyword::sol_at_vertices);
        if (!block) return gmf::fail_at(*file, 0, "the file has no SolAtVertices", "give a solution (.sol, .solb)");
        auto solution = gmf::read_solution(*file, *block, part_of(execution, of_index, 1));
        if (!solution) return fail(std::move(solution.error()));
        return DecodedSolution{std::move(*solution), gmf::notices_of(*file)};
    });
}

Outcome<Chunks> encode_gmf_solution(const Solution& solution, GmfOptions options, const Execution& execution) {
    if (solution.dimension != 2 && solution.dimension != 3)
        return fail(ErrorKind::usage,
                    "the solution's dimension is " + std::to_string(solution.dimension) + ", not 2 or 3");
    if (solution.fields.empty()) return fail(ErrorKind::usage, "the solution has no fields");
    if (solution.values.size() != solution.rows * row_width(solution))
        return fail(ErrorKind::usage, "the solution does not have the values that its fields and rows need");
    return guarded([&] { return gmf::encode(solution, options, execution); });
}

}  // namespace camber
