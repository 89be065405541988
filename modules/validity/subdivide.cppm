module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
export module camber.validity:subdivide;
import camber.core;
import camber.bezier;
import :coefficients;
import :jacobian;

export namespace camber {

/// One averaging of de Casteljau's algorithm: c[target] ← (c[target] + c[source]) / 2.
struct Averaging {
    std::uint8_t target, source;
};

/// Averagings that a bisection takes: Σ α_j over the multi-indices.
template <int D>
inline constexpr int averagings = jacobian_coefficients<D> * D / (D + 1);

/// The averagings that move vertex `from` of a simplex to the middle of its edge to vertex `to`, in place: round r
/// treats the indices with α_from ≥ r, higher α_from first, so that each source is still of the round before.
template <int D>
[[nodiscard]] constexpr std::array<Averaging, averagings<D>> bisection(int from, int to) {
    std::array<Averaging, averagings<D>> steps{};
    int n = 0;
    for (int round = 1; round <= D; ++round)
        for (int power_of = D; power_of >= round; --power_of)
            for (int p = 0; p < jacobian_coefficients<D>; ++p) {
                auto alpha = jacobian_indices<D>[p];
                if (alpha[from] != power_of) continue;
                --alpha[from];
                ++alpha[to];
                steps[n++] = {static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(position<D, D>(alpha))};
            }
    return steps;
}

/// bisections<D>[edge][side]: those that keep the part at that end of the edge.
template <int D>
inline constexpr auto bisections = [] {
    std::array<std::array<std::array<Averaging, averagings<D>>, 2>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto ends = local_edges<D>[e];
        for (int side = 0; side < 2; ++side) table[e][side] = bisection<D>(ends[side], ends[1 - side]);
    }
    return table;
}();

}  // namespace camber

namespace camber {

/// Positions of γ + 2e_i, γ + e_i + e_j, γ + 2e_j for each edge i–j and γ of degree D − 2.
template <int D>
inline constexpr auto second_differences = [] {
    constexpr int rows = node_count<D - 2, D>;
    std::array<std::array<std::array<int, 3>, rows>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int r = 0; r < rows; ++r)
            for (int m = 0; m < 3; ++m) {
                auto alpha = multi_indices<D - 2, D>[r];
                alpha[local_edges<D>[e][0]] += 2 - m;
                alpha[local_edges<D>[e][1]] += m;
                table[e][r][m] = position<D, D>(alpha);
            }
    return table;
}();

}  // namespace camber

export namespace camber {

/// A part of an element: the Bézier coefficients of det J on it, and its corners in the element.
template <int D>
struct JacobianPart {
    std::array<double, jacobian_coefficients<D>> coefficients{};
    std::array<Barycentric<D>, D + 1> corners{};
    int depth = 0;
};

template <int D>
[[nodiscard]] constexpr JacobianPart<D> whole(const BoundedJacobian<D>& jacobian) {
    JacobianPart<D> part{jacobian.coefficients, {}, 0};
    for (int i = 0; i <= D; ++i) part.corners[i][i] = 1;
    return part;
}

/// The local edge along which the coefficients bend most, and by how much. Second differences along the edges determine
/// all of them: where they vanish, det J is affine and its minimum at a corner.
struct Bend {
    int edge = 0;
    double size = 0;
};
template <int D>
[[nodiscard]] inline Bend largest_bend(const JacobianPart<D>& part) {
    Bend bend;
    const auto& c = part.coefficients;
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (const auto& [i, m, j] : second_differences<D>[e]) {
            const double size = std::abs((c[i] - c[m]) + (c[j] - c[m]));
            if (size > bend.size) bend = {e, size};
        }
    return bend;
}

/// The half of a part on one side (0, 1) of the middle of a local edge: vertex local_edges[edge][side] moves there.
template <int D>
[[nodiscard]] inline JacobianPart<D> half(JacobianPart<D> part, int edge, int side) {
    for (const auto [target, source] : bisections<D>[edge][side])
        part.coefficients[target] = 0.5 * (part.coefficients[target] + part.coefficients[source]);
    const int from = local_edges<D>[edge][side];
    const int to = local_edges<D>[edge][1 - side];
    for (int i = 0; i <= D; ++i) part.corners[from][i] = 0.5 * (part.corners[from][i] + part.corners[to][i]);
    ++part.depth;
    return part;
}

}  // namespace camber
