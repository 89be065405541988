module;
#include <cstddef>
#include <cstdint>
module camber.io:gmf_ascii;
import camber.core;
import :first_fault;
import :gmf_binary;
import :gmf_file;
import :gmf_row;
import :text;

namespace camber::gmf {

/// False when a word is no number of its kind.
template <class RowType>
[[nodiscard]] inline bool read_row(Words& words, RowType& row) {
    if constexpr (RowType::order == RowOrder::reals_first)
        for (double& real : row.real)
            if (!read_number(words, real)) return false;
    for (std::int64_t& integer : row.integer)
        if (!read_number(words, integer)) return false;
    if constexpr (RowType::order == RowOrder::integers_first)
        for (double& real : row.real)
            if (!read_number(words, real)) return false;
    return true;
}

[[nodiscard]] inline Words words_between(const File& file, std::size_t begin, std::size_t end) {
    const char* const text = reinterpret_cast<const char*>(file.bytes.data());
    return {text + begin, text + end};
}

/// store(row number, row) → Fault for each row of a checked block, piece by piece in parallel: a piece's thread reads
/// the rows that begin in it.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_ascii_rows(const File& file, const Block& block, const Execution& execution,
                                            Store& store) {
    constexpr std::size_t width = RowType::words;
    const auto read_one = [&](std::size_t i, Words& words) {
        RowType row;
        return read_row(words, row) ? store(i, row) : Fault{.kind = FaultKind::syntax};
    };
    FirstFault first;
    auto done = each_chunk(
        execution, block.pieces.size(),
        [&](std::size_t begin, std::size_t end) {
            const std::size_t first_word = block.pieces[begin].first_word;
            const std::size_t last_word = end < block.pieces.size() ? block.pieces[end].first_word : block.words;
            std::size_t row = (first_word + width - 1) / width;
            Words words = words_between(file, block.pieces[begin].begin, block.end);
            words.skip(row * width - first_word);
            for (; row < block.count && row * width < last_word; ++row)
                if (read_one(row, words).kind != FaultKind::none) return first.note(row);
        },
        1);
    if (!done) return done;
    if (!first.any()) return Done{};
    const std::size_t at = row_begin(file, block, first.row(), RowType::integers, RowType::reals);
    Words words = words_between(file, at, block.end);
    return fail(fault_error(file, block, first.row(), at, read_one(first.row(), words)));
}

}  // namespace camber::gmf
