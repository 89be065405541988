// Elements with integer nodes, and their Jacobian coefficients and verdicts in exact integers. The includer imports
// camber.core, camber.bezier and camber.validity first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace elements {

using namespace camber;

__extension__ using Integer = __int128;

/// Lagrange nodes, in the order of NodalSimplex.
template <int D>
using IntegerNodes = std::array<std::array<std::int64_t, D>, quadratic_nodes<D>>;

template <int D>
NodalSimplex<D> nodal(const IntegerNodes<D>& nodes) {
    NodalSimplex<D> s;
    for (int i = 0; i < quadratic_nodes<D>; ++i)
        for (int c = 0; c < D; ++c) s.nodes[i][c] = static_cast<double>(nodes[i][c]);
    return s;
}

template <int D>
int node_of(int i, int j) {
    if (i == j) return i;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [a, b] = local_edges<D>[e];
        if ((a == i && b == j) || (a == j && b == i)) return D + 1 + e;
    }
    return -1;
}

/// 6 times the coefficients of det J, exact: the sum over all D-tuples of vertices of the determinants of twice the
/// columns' control vectors, 4 (n_ia − n_i0) − (p_a − p_0).
template <int D>
std::vector<Integer> sixfold_coefficients(const IntegerNodes<D>& n) {
    const auto column = [&](int a, int i, int c) {
        return Integer{4} * (n[node_of<D>(i, a)][c] - n[node_of<D>(i, 0)][c]) - (n[a][c] - n[0][c]);
    };
    std::vector<Integer> sums(jacobian_coefficients<D>, 0);
    for (int i = 0; i <= D; ++i)
        for (int j = 0; j <= D; ++j) {
            if constexpr (D == 2) {
                MultiIndex<2> alpha{};
                ++alpha[i], ++alpha[j];
                sums[position<2, 2>(alpha)] += column(1, i, 0) * column(2, j, 1) - column(1, i, 1) * column(2, j, 0);
            } else {
                for (int k = 0; k <= 3; ++k) {
                    MultiIndex<3> alpha{};
                    ++alpha[i], ++alpha[j], ++alpha[k];
                    for (int c = 0; c < 3; ++c) {
                        const int d = (c + 1) % 3;
                        const int e = (c + 2) % 3;
                        sums[position<3, 3>(alpha)] +=
                            column(1, i, c) * (column(2, j, d) * column(3, k, e) - column(2, j, e) * column(3, k, d));
                    }
                }
            }
        }
    for (int p = 0; p < jacobian_coefficients<D>; ++p)
        sums[p] *= 6 / static_cast<int>(multinomial<D>(multi_indices<D, D>[p]));
    return sums;
}

/// Decides whether det J > 0 everywhere, by exact bisection of the integers at alternating edges; undecided after
/// `most` levels. Each bisection multiplies the coefficients by 2^D, so node coordinates must be small.
template <int D>
Verdict exact_verdict(const std::vector<Integer>& c, int most, int depth = 0) {
    bool all = true;
    for (const Integer x : c) all = all && x > 0;
    if (all) return Verdict::valid;
    for (int i = 0; i <= D; ++i) {
        MultiIndex<D> corner{};
        corner[i] = D;
        if (c[position<D, D>(corner)] <= 0) return Verdict::invalid;
    }
    if (depth == most) return Verdict::undecided;
    const auto ends = local_edges<D>[depth % edges_per_simplex<D>];
    bool undecided = false;
    for (int side = 0; side < 2; ++side) {
        const int from = ends[side];
        const int to = ends[1 - side];
        std::vector<Integer> part(c.size(), 0);
        for (std::size_t p = 0; p < c.size(); ++p) {
            // Blossom: each of the α_from arguments `from` becomes (from + to)/2; the factor is 2^D in total.
            auto alpha = multi_indices<D, D>[p];
            const int m = alpha[from];
            for (int k = 0; k <= m; ++k) {
                part[p] += binomial(m, k) * (Integer{1} << (D - m)) * c[position<D, D>(alpha)];
                --alpha[from], ++alpha[to];
            }
        }
        const Verdict verdict = exact_verdict<D>(part, most, depth + 1);
        if (verdict == Verdict::invalid) return verdict;
        undecided = undecided || verdict == Verdict::undecided;
    }
    return undecided ? Verdict::undecided : Verdict::valid;
}

/// det J at a point.
template <int D>
double jacobian_at(const QuadraticSimplex<D, D>& s, const Barycentric<D>& xi) {
    const auto d = s.derivatives(xi);
    if constexpr (D == 2)
        return det(d[0], d[1]);
    else
        return det(d[0], d[1], d[2]);
}

/// The lattice of degree n on the reference simplex.
template <int D>
std::vector<Barycentric<D>> lattice(int n) {
    std::vector<Barycentric<D>> points;
    const auto add = [&](auto&& self, Barycentric<D> xi, int at, int left) -> void {
        if (at == D) {
            xi[D] = static_cast<double>(left) / n;
            points.push_back(xi);
            return;
        }
        for (int k = 0; k <= left; ++k) {
            xi[at] = static_cast<double>(k) / n;
            self(self, xi, at + 1, left - k);
        }
    };
    add(add, {}, 0, n);
    return points;
}

}  // namespace elements
