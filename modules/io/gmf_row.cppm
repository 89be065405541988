module;
#include <array>
#include <cmath>
#include <cstddef>
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

template <int D>
[[nodiscard]] inline Fault store_point(const VertexRow<D>& row, Vec<D>& point, Reference& reference) {
    bool finite = true;
    for (int c = 0; c < D; ++c) {
        point[c] = row.real[c];
        finite = finite && std::isfinite(row.real[c]);
    }
    if (!finite) return {FaultKind::not_finite};
    if (!is_reference(row.integer[0])) return {FaultKind::too_large, row.integer[0]};
    reference = static_cast<Reference>(row.integer[0]);
    return {};
}

/// Edges may be from a vertex to itself.
template <int N>
[[nodiscard]] inline Fault store_simplex(const SimplexRow<N>& row, std::size_t vertices, std::array<VertexId, N>& nodes,
                                         Reference& reference) {
    for (int n = 0; n < N; ++n) {
        if (from_file(row.integer[n]) >= vertices) return {FaultKind::index, row.integer[n], vertices};
        nodes[n] = VertexId(from_file(row.integer[n]));
        for (int m = 0; m < n && N > 2; ++m)
            if (row.integer[m] == row.integer[n]) return {FaultKind::repeated, row.integer[n]};
    }
    if (!is_reference(row.integer[N])) return {FaultKind::too_large, row.integer[N]};
    reference = static_cast<Reference>(row.integer[N]);
    return {};
}

}  // namespace camber::gmf
