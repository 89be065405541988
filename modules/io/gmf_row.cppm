module;
#include <array>
#include <cstdint>
#include <limits>
module camber.io:gmf_row;
import camber.core;

namespace camber::gmf {

enum class RowOrder { integers_first, reals_first };

/// One row of a block, whatever the file's encoding: its integers and its reals, in the order given.
template <int Integers, int Reals, RowOrder Order = RowOrder::integers_first>
struct Row {
    static constexpr int integers = Integers, reals = Reals, words = Integers + Reals;
    static constexpr RowOrder order = Order;
    std::array<std::int64_t, Integers> integer{};
    std::array<double, Reals> real{};
};

template <int D>
using VertexRow = Row<1, D, RowOrder::reals_first>;
template <int Nodes>
using SimplexRow = Row<Nodes + 1, 0>;
using IndexRow = Row<1, 0>;
using PairRow = Row<2, 0>;
template <int D>
using VectorRow = Row<0, D>;
/// Vertex and entity of dimension G; parameters, and the distance; of a point neither.
template <int G>
using AssociationRow = Row<2, G == 0 ? 0 : G + 1>;
using ValueRow = Row<0, 1>;

/// What is wrong with a row; the number that is wrong, and what it should have been at most.
enum class FaultKind : std::uint8_t { none, syntax, index, repeated, not_finite, too_large };
struct Fault {
    FaultKind kind = FaultKind::none;
    std::int64_t value = 0;
    std::uint64_t limit = 0;
};

/// The index of a file (from 1) as one from 0; a value ≥ n when it is out of range.
[[nodiscard]] constexpr std::uint64_t from_file(std::int64_t index) { return static_cast<std::uint64_t>(index) - 1; }

[[nodiscard]] constexpr bool is_reference(std::int64_t value) {
    return value >= std::numeric_limits<Reference>::min() && value <= std::numeric_limits<Reference>::max();
}

}  // namespace camber::gmf
