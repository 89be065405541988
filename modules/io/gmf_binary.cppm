module;
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
module camber.io:gmf_binary;
import camber.core;
import :first_fault;
import :gmf_file;
import :gmf_row;

namespace camber::gmf {

/// How numbers lie in a binary file.
template <class RealType, class IntegerType, ByteOrder Order>
struct Layout {
    using Real = RealType;
    using Integer = IntegerType;
    static constexpr ByteOrder order = Order;
};

template <class T, ByteOrder Order>
[[nodiscard]] inline T load(const std::byte* from) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    Bits bits;
    std::memcpy(&bits, from, sizeof bits);
    if constexpr (Order == ByteOrder::swapped) {
        if constexpr (sizeof(T) == 4)
            bits = __builtin_bswap32(bits);
        else
            bits = __builtin_bswap64(bits);
    }
    T value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

template <class RowType, class LayoutType>
inline constexpr std::size_t stride =
    RowType::integers * sizeof(typename LayoutType::Integer) + RowType::reals * sizeof(typename LayoutType::Real);

template <class RowType, class LayoutType>
[[nodiscard]] inline RowType load_row(const std::byte* from) {
    using Integer = typename LayoutType::Integer;
    using Real = typename LayoutType::Real;
    constexpr bool reals_first = RowType::order == RowOrder::reals_first;
    const std::byte* integers = reals_first ? from + RowType::reals * sizeof(Real) : from;
    const std::byte* reals = reals_first ? from : from + RowType::integers * sizeof(Integer);
    RowType row;
    for (int i = 0; i < RowType::integers; ++i)
        row.integer[i] = load<Integer, LayoutType::order>(integers + i * sizeof(Integer));
    for (int i = 0; i < RowType::reals; ++i)
        row.real[i] = static_cast<double>(load<Real, LayoutType::order>(reals + i * sizeof(Real)));
    return row;
}

/// Calls f(Layout{}) with the file's layout: the one switch, outside of all loops.
template <class F>
auto with_layout(const File& file, F&& f) {
    const auto with_numbers = [&]<ByteOrder Order>() {
        if (file.version == 1) return f(Layout<float, std::int32_t, Order>{});
        if (file.version == 4) return f(Layout<double, std::int64_t, Order>{});
        return f(Layout<double, std::int32_t, Order>{});
    };
    if (file.order == ByteOrder::swapped) return with_numbers.template operator()<ByteOrder::swapped>();
    return with_numbers.template operator()<ByteOrder::native>();
}

/// store(row number, row) → Fault for each row of a checked block, in parallel.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_binary_rows(const File& file, const Block& block, const Execution& execution,
                                             Store& store) {
    return with_layout(file, [&](auto layout) -> Outcome<Done> {
        using LayoutType = decltype(layout);
        constexpr std::size_t step = stride<RowType, LayoutType>;
        const std::byte* const rows = file.bytes.data() + block.body;
        FirstFault first;
        auto done = each_chunk(
            execution, block.count,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const Fault fault = store(i, load_row<RowType, LayoutType>(rows + i * step));
                    if (fault.kind != FaultKind::none) return first.note(i);
                }
            },
            8192);
        if (!done) return done;
        if (!first.any()) return Done{};
        const std::size_t at = block.body + first.row() * step;
        const Fault fault = store(first.row(), load_row<RowType, LayoutType>(file.bytes.data() + at));
        return fail(fault_error(file, block, first.row(), at, fault));
    });
}

}  // namespace camber::gmf
