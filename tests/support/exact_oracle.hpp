// Validity of P2 elements in integer arithmetic that shares no code with the library: det J from the shape functions at
// integer weights, its Bernstein coefficients by interpolation, then bisection along edges; triangles by the minimum of
// a polynomial in x and y. Slow and simple. The includer imports camber.core, camber.bezier and camber.validity first.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

namespace oracle {

using Big = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
__extension__ using Wide = __int128;

enum class Answer { valid, invalid, unknown };

template <int D, class Integer>
using Nodes = std::array<std::array<Integer, D>, (D + 1) * (D + 2) / 2>;
template <int D, class Integer>
using Whole = std::array<Integer, D + 1>;

/// Index of the node of edge i–j in the order (0,1), (0,2), … of the local edges; of the vertex if i = j.
template <int D>
int node(int i, int j) {
    if (i == j) return i;
    for (int e = 0; e < camber::edges_per_simplex<D>; ++e) {
        const auto& ends = camber::local_edges<D>[e];
        if ((ends[0] == i && ends[1] == j) || (ends[0] == j && ends[1] == i)) return D + 1 + e;
    }
    return -1;
}

template <class Integer>
Integer determinant(const std::array<std::array<Integer, 2>, 2>& m) {
    return m[0][0] * m[1][1] - m[0][1] * m[1][0];
}
template <class Integer>
Integer determinant(const std::array<std::array<Integer, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// q^D det J at the point w/q, q = Σw: q ∂_a F = (4 w_a − q) p_a + 4 Σ_j w_j n_aj.
template <int D, class Integer>
Integer determinant_at(const Nodes<D, Integer>& n, const Whole<D, Integer>& w) {
    Integer q = 0;
    for (const Integer& x : w) q += x;
    const auto slope = [&](int a, int c) {
        Integer sum = (4 * w[a] - q) * n[a][c];
        for (int j = 0; j <= D; ++j)
            if (j != a) sum += 4 * w[j] * n[node<D>(a, j)][c];
        return sum;
    };
    std::array<std::array<Integer, D>, D> m;
    for (int c = 0; c < D; ++c) {
        const Integer first = slope(0, c);
        for (int a = 1; a <= D; ++a) m[a - 1][c] = slope(a, c) - first;
    }
    return determinant(m);
}

template <int D, class Integer>
Integer straight(const Nodes<D, Integer>& n) {
    std::array<std::array<Integer, D>, D> m;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) m[a - 1][c] = n[a][c] - n[0][c];
    return determinant(m);
}

/// Required share of |det straight|: numerator/denominator ≥ 0.
template <class Integer>
struct Share {
    Integer numerator = 0, denominator = 1;
};

/// True if det J is positive and at least `least`, both multiplied by the same positive number.
template <class Integer>
bool enough(const Integer& value, const Integer& least) {
    return value > 0 && value >= least;
}

/// True if the condition holds at w/Σw.
template <int D, class Integer>
bool holds_at(const Nodes<D, Integer>& n, const Whole<D, Integer>& w, const Share<Integer>& share) {
    Integer q = 0;
    for (const Integer& x : w) q += x;
    Integer least = straight<D>(n) * share.numerator;
    if (least < 0) least = -least;
    for (int i = 0; i < D; ++i) least *= q;
    return enough<Integer>(determinant_at<D>(n, w) * share.denominator, least);
}

/// Scaled Bernstein coefficients of det J by multi-index, and the required minimum.
template <int D, class Integer>
struct Coefficients {
    /// In the order of camber::jacobian_indices<D>, times the factor 4 · 2 (2D) or 27 · 12 (3D).
    std::vector<Integer> of;
    Integer least;  ///< with the same factor
};

template <int D>
constexpr int place(std::array<int, D + 1> alpha) {
    return camber::position<D, D>(alpha);
}

template <int D, class Integer>
Coefficients<D, Integer> coefficients(const Nodes<D, Integer>& n, const Share<Integer>& share) {
    constexpr int count = camber::jacobian_coefficients<D>;
    std::array<Integer, count> f;
    for (int p = 0; p < count; ++p) {
        Whole<D, Integer> w;
        for (int i = 0; i <= D; ++i) w[i] = camber::jacobian_indices<D>[p][i];
        f[p] = determinant_at<D>(n, w);
    }
    Coefficients<D, Integer> c{std::vector<Integer>(count, Integer(0)), straight<D>(n) * share.numerator};
    if (c.least < 0) c.least = -c.least;
    const auto at = [](int i, int j, int k) {
        std::array<int, D + 1> alpha{};
        ++alpha[i], ++alpha[j];
        if (k >= 0) ++alpha[k];
        return place<D>(alpha);
    };
    if constexpr (D == 2) {
        c.least *= 8;
        for (int i = 0; i <= 2; ++i) {
            c.of[at(i, i, -1)] = 2 * f[at(i, i, -1)];
            for (int j = 0; j < i; ++j) c.of[at(i, j, -1)] = 4 * f[at(i, j, -1)] - f[at(i, i, -1)] - f[at(j, j, -1)];
        }
    } else {
        c.least *= 12 * 27;
        for (int i = 0; i <= 3; ++i) {
            c.of[at(i, i, i)] = 12 * f[at(i, i, i)];
            for (int j = 0; j <= 3; ++j)
                if (j != i)
                    c.of[at(i, i, j)] =
                        2 * (18 * f[at(i, i, j)] - 9 * f[at(i, j, j)] - 5 * f[at(i, i, i)] + 2 * f[at(j, j, j)]);
        }
        for (int skip = 0; skip <= 3; ++skip) {
            std::array<int, 3> v{};
            for (int i = 0, m = 0; i <= 3; ++i)
                if (i != skip) v[m++] = i;
            Integer sum = 54 * f[at(v[0], v[1], v[2])];
            for (const int i : v) {
                sum -= 2 * f[at(i, i, i)];
                for (const int j : v)
                    if (j != i) sum -= c.of[at(i, i, j)] / 2;
            }
            c.of[at(v[0], v[1], v[2])] = sum;
        }
    }
    for (Integer& x : c.of) x *= share.denominator;
    return c;
}

/// Returns the edge with the maximum of |c_(γ+2i) − 2 c_(γ+i+j) + c_(γ+2j)|.
template <int D, class Integer>
int max_bent(const Coefficients<D, Integer>& c) {
    int found = 0;
    Integer most = -1;
    for (int e = 0; e < camber::edges_per_simplex<D>; ++e) {
        const auto [i, j] = camber::local_edges<D>[e];
        for (auto alpha : camber::jacobian_indices<D>) {
            if (alpha[i] == 0 || alpha[j] == 0) continue;
            Integer bend = -2 * c.of[place<D>(alpha)];
            ++alpha[i], --alpha[j];
            bend += c.of[place<D>(alpha)];
            alpha[i] -= 2, alpha[j] += 2;
            bend += c.of[place<D>(alpha)];
            if (bend < 0) bend = -bend;
            if (bend > most) most = bend, found = e;
        }
    }
    return found;
}

/// Bisects along the edge of maximum second difference. `least` is multiplied by 2^D at each level, like the
/// coefficients.
template <int D, class Integer>
Answer bisected(const Coefficients<D, Integer>& c, int max_depth, int& parts, int depth = 0) {
    bool all = true;
    for (const Integer& x : c.of) all = all && enough(x, c.least);
    if (all) return Answer::valid;
    for (int i = 0; i <= D; ++i) {
        std::array<int, D + 1> corner{};
        corner[i] = D;
        if (!enough(c.of[place<D>(corner)], c.least)) return Answer::invalid;
    }
    if (depth == max_depth || --parts < 0) return Answer::unknown;
    const auto ends = camber::local_edges<D>[max_bent<D, Integer>(c)];
    bool unknown = false;
    for (int side = 0; side < 2; ++side) {
        const int from = ends[side];
        const int to = ends[1 - side];
        Coefficients<D, Integer> part{std::vector<Integer>(c.of.size(), Integer(0)), c.least * (1 << D)};
        for (int p = 0; p < camber::jacobian_coefficients<D>; ++p) {
            // Blossom: each of the m arguments `from` becomes (from + to)/2.
            auto alpha = camber::jacobian_indices<D>[p];
            const int m = alpha[from];
            for (int k = 0, choose = 1; k <= m; choose = choose * (m - k) / (k + 1), ++k) {
                part.of[p] += c.of[place<D>(alpha)] * (choose * (1 << (D - m)));
                if (k < m) --alpha[from], ++alpha[to];
            }
        }
        const Answer answer = bisected<D, Integer>(part, max_depth, parts, depth + 1);
        if (answer == Answer::invalid) return answer;
        unknown = unknown || answer == Answer::unknown;
    }
    return unknown ? Answer::unknown : Answer::valid;
}

/// Triangles: g = det J − least is a polynomial A x² + B xy + C y² + E x + F y + G of x = ξ_1, y = ξ_2, computed from
/// values at vertices and edge middles. The element is invalid if g < 0, and also if g = 0 when only det J > 0 is
/// required.
template <class Integer>
Answer triangle(const Nodes<2, Integer>& n, const Share<Integer>& share) {
    Integer least = 4 * straight<2>(n) * share.numerator;
    if (least < 0) least = -least;
    const auto value = [&](int a, int b, int c) {
        return Integer(determinant_at<2, Integer>(n, {Integer(a), Integer(b), Integer(c)}) * share.denominator - least);
    };
    const bool strict = least == 0;
    const auto fails = [&](const Integer& x) { return x < 0 || (strict && x == 0); };
    const Integer v0 = value(2, 0, 0), v1 = value(0, 2, 0), v2 = value(0, 0, 2);
    const Integer m01 = value(1, 1, 0), m02 = value(1, 0, 1), m12 = value(0, 1, 1);
    if (fails(v0) || fails(v1) || fails(v2)) return Answer::invalid;
    // a t² + b t + c through p, m, q at 0, 1/2, 1. Its minimum is c − b²/4a where 0 < −b < 2a.
    const auto edge_fails = [&](const Integer& p, const Integer& m, const Integer& q) {
        const Integer a = 2 * p - 4 * m + 2 * q;
        const Integer b = 4 * m - 3 * p - q;
        return a > 0 && b < 0 && -b < 2 * a && fails(4 * a * p - b * b);
    };
    if (edge_fails(v0, m01, v1) || edge_fails(v0, m02, v2) || edge_fails(v1, m12, v2)) return Answer::invalid;
    const Integer a = 2 * v0 - 4 * m01 + 2 * v1;
    const Integer c = 2 * v0 - 4 * m02 + 2 * v2;
    const Integer e = 4 * m01 - 3 * v0 - v1;
    const Integer f = 4 * m02 - 3 * v0 - v2;
    const Integer b = 4 * v0 + 4 * m12 - 4 * m01 - 4 * m02;
    const Integer h = 4 * a * c - b * b;
    const Integer x = b * f - 2 * c * e;
    const Integer y = b * e - 2 * a * f;
    if (h > 0 && a > 0 && x > 0 && y > 0 && x + y < h && fails(2 * h * v0 + e * x + f * y)) return Answer::invalid;
    return Answer::valid;
}

struct Limits {
    int depth, parts, denominator;
};

/// Decides whether det J > 0 and det J ≥ share · |det straight| everywhere. `Integer` stores values, `Longer` bisected
/// coefficients. If bisection leaves the answer open, all points with denominators up to the limit are tested.
template <int D, class Longer, class Integer>
Answer answer(const Nodes<D, Integer>& n, const Share<Integer>& share, const Limits& limits) {
    if constexpr (D == 2) {
        return triangle<Integer>(n, share);
    } else {
        for (int i = 0; i <= D; ++i) {
            Whole<D, Integer> w{};
            for (int j = 0; j <= D; ++j) w[j] = i == j;
            if (!holds_at<D>(n, w, share)) return Answer::invalid;
        }
        const auto c = coefficients<D, Integer>(n, share);
        Coefficients<D, Longer> longer{std::vector<Longer>(c.of.begin(), c.of.end()), Longer(c.least)};
        int parts = limits.parts;
        const Answer found = bisected<D, Longer>(longer, limits.depth, parts);
        if (found != Answer::unknown) return found;
        for (int q = 1; q <= limits.denominator; ++q)
            for (int a = 0; a <= q; ++a)
                for (int b = 0; a + b <= q; ++b)
                    for (int d = 0; a + b + d <= q; ++d)
                        if (!holds_at<3, Integer>(n, {Integer(a), Integer(b), Integer(d), Integer(q - a - b - d)},
                                                  share))
                            return Answer::invalid;
        return Answer::unknown;
    }
}

/// Exponent of the last nonzero bit of a double that is not 0.
inline int last_bit(double x) {
    int exponent = 0;
    std::frexp(x, &exponent);
    return exponent - 53;
}
inline Big scaled(double x, int lowest) {
    if (x == 0) return 0;
    int exponent = 0;
    const double m = std::frexp(x, &exponent);
    return Big(static_cast<std::int64_t>(std::ldexp(m, 53))) << (exponent - 53 - lowest);
}
template <class Doubles>
int lowest_bit(const Doubles& values) {
    int lowest = 2000;
    for (const double x : values)
        if (x != 0) lowest = std::min(lowest, last_bit(x));
    return lowest;
}

/// Returns the nodes of several elements times a common power of two, as integers.
template <int D, std::size_t N>
std::array<Nodes<D, Big>, N> big_nodes(const std::array<camber::NodalSimplex<D>, N>& elements) {
    std::vector<double> all;
    all.reserve(N * (D + 1) * (D + 2) * D);
    for (const auto& s : elements)
        for (const auto& p : s.nodes) all.insert(all.end(), p.c.begin(), p.c.end());
    const int lowest = lowest_bit(all);
    std::array<Nodes<D, Big>, N> out;
    for (std::size_t m = 0; m < N; ++m)
        for (std::size_t i = 0; i < out[m].size(); ++i)
            for (int c = 0; c < D; ++c) out[m][i][c] = scaled(elements[m].nodes[i][c], lowest);
    return out;
}
template <int D>
Nodes<D, Big> big_nodes(const camber::NodalSimplex<D>& s) {
    return big_nodes<D, 1>({s})[0];
}

template <int D>
Whole<D, Big> big_weights(const camber::Barycentric<D>& point) {
    const int lowest = lowest_bit(point);
    Whole<D, Big> w;
    for (int i = 0; i <= D; ++i) w[i] = scaled(point[i], lowest);
    return w;
}

inline Share<Big> share_of(double bound) {
    if (!(bound > 0)) return {};
    const int lowest = last_bit(bound);
    return {scaled(bound, std::min(lowest, 0)), Big(1) << std::max(0, -lowest)};
}

/// The answer for an element with the stored doubles.
template <int D>
Answer answer(const camber::NodalSimplex<D>& s, double bound, const Limits& limits = {400, 20000, 8}) {
    return answer<D, Big, Big>(big_nodes<D>(s), share_of(bound), limits);
}
template <int D>
bool holds_at(const camber::NodalSimplex<D>& s, const camber::Barycentric<D>& point, double bound) {
    return holds_at<D, Big>(big_nodes<D>(s), big_weights<D>(point), share_of(bound));
}

}  // namespace oracle
