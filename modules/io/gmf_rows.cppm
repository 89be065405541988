module camber.io:gmf_rows;
import camber.core;
import :gmf;
import :gmf_ascii;
import :gmf_binary;
import :gmf_file;

namespace camber::gmf {

/// store(row number, row) → Fault for each row of the block, in parallel and in no particular order. Errors: a count
/// that does not fit the block, the first row at fault, stopped.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_rows(const File& file, const Block& block, const Execution& execution, Store&& store) {
    if (auto fits = check_size(file, block, RowType::integers, RowType::reals); !fits) return fits;
    if (file.encoding == GmfEncoding::ascii) return read_ascii_rows<RowType>(file, block, execution, store);
    return read_binary_rows<RowType>(file, block, execution, store);
}

}  // namespace camber::gmf
