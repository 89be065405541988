module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.validity:tensor;
import camber.core;
import camber.bezier;
import :coefficients;
import :subdivide;
import :verdict;

/// det J of an element in motion, and of one at rest, by coefficients of any kind of number; its bisection.
namespace camber {

/// Longest path to a part, for any kind of number.
inline constexpr int longest_path = 240;

/// det J(ξ, s) on a part of an element and of a motion: Bernstein coefficients of degree D in ξ and S in s (S = 0: at
/// rest), `values[k][α]`; those of det of the straight element, `straight[k]`, in the same unit. `path` tells which
/// part it is: bisections by 2 · direction + side, the direction being a local edge, or s for the one after the last.
template <int D, int S, class Number>
struct Tensor {
    std::array<std::array<Number, jacobian_coefficients<D>>, S + 1> values{};
    std::array<Number, S + 1> straight{};
    std::array<std::uint8_t, longest_path> path{};
    int depth = 0;
};

template <int D>
inline constexpr int step_direction = edges_per_simplex<D>;

/// Sums of neighbours are not halved one by one: what took m of n sums is 2^m times too large, and Halving makes up for
/// it. In doubles by 2⁻ᵐ, exact but for underflow; in integers by 2^(n−m), so that all of them grow by 2ⁿ.
template <class Number>
struct Halving {
    [[nodiscard]] static Number of(const Number& x, int m, int) { return x * (1.0 / (1 << m)); }
};

/// The half on one side of the middle of a direction.
template <int D, int S, class Number>
[[nodiscard]] Tensor<D, S, Number> half(Tensor<D, S, Number> part, int direction, int side) {
    part.path[part.depth++] = static_cast<std::uint8_t>(2 * direction + side);
    if (direction < step_direction<D>) {
        const int from = local_edges<D>[direction][side];
        for (auto& row : part.values) {
            for (const auto [target, source] : bisections<D>[direction][side]) row[target] += row[source];
            for (int p = 0; p < jacobian_coefficients<D>; ++p)
                row[p] = Halving<Number>::of(row[p], jacobian_indices<D>[p][from], D);
        }
        for (auto& x : part.straight) x = Halving<Number>::of(x, 0, D);
    } else if constexpr (S > 0) {
        // Side 0 keeps s = 0: row k becomes the sum of binomials of rows 0 … k.
        const auto row = [&](int k) { return side == 0 ? k : S - k; };
        for (int round = 1; round <= S; ++round)
            for (int k = S; k >= round; --k) {
                for (int p = 0; p < jacobian_coefficients<D>; ++p) part.values[row(k)][p] += part.values[row(k - 1)][p];
                part.straight[row(k)] += part.straight[row(k - 1)];
            }
        for (int k = 0; k <= S; ++k) {
            for (Number& x : part.values[row(k)]) x = Halving<Number>::of(x, k, S);
            part.straight[row(k)] = Halving<Number>::of(part.straight[row(k)], k, S);
        }
    }
    return part;
}

template <class Number>
struct TensorBend {
    int direction = 0;
    Number size{};
};

/// The direction in which the coefficients bend most. Where none does, det J is affine in ξ and in s, and its minimum
/// at a corner.
template <int D, int S, class Number>
[[nodiscard]] TensorBend<Number> largest_bend(const Tensor<D, S, Number>& part) {
    TensorBend<Number> bend;
    const auto look = [&](int direction, const Number& a, const Number& m, const Number& b) {
        Number size = (a - m) + (b - m);
        if (size < 0) size = -size;
        if (size > bend.size) bend = {direction, std::move(size)};
    };
    for (const auto& c : part.values)
        for (int e = 0; e < edges_per_simplex<D>; ++e)
            for (const auto& [i, m, j] : second_differences<D>[e]) look(e, c[i], c[m], c[j]);
    for (int k = 0; k + 2 <= S; ++k)
        for (int p = 0; p < jacobian_coefficients<D>; ++p)
            look(step_direction<D>, part.values[k][p], part.values[k + 1][p], part.values[k + 2][p]);
    return bend;
}

/// Of the coefficients at corners in ξ and s, which are values of det J, the smallest: row and local vertex.
template <int D, int S, class Number>
[[nodiscard]] std::pair<int, int> lowest_corner(const Tensor<D, S, Number>& part) {
    std::pair<int, int> lowest{0, 0};
    for (int k = 0; k <= S; k += (S > 0 ? S : 1))
        for (int i = 0; i <= D; ++i)
            if (part.values[k][corner_coefficients<D>[i]] <
                part.values[lowest.first][corner_coefficients<D>[lowest.second]])
                lowest = {k, i};
    return lowest;
}

/// What a look at a part says.
enum class PartVerdict : std::uint8_t { good, bad, split, stuck };

struct SearchLimits {
    int depth, parts;
};

/// Depth first, the half with the lower corner first. `look(part)` judges; `bad(part)` is told of the part that ends
/// the search. Undecided when a part was stuck or a limit met, and no part was bad.
template <int D, int S, class Number, class Look, class Bad>
[[nodiscard]] Verdict search(Tensor<D, S, Number> whole, const SearchLimits& limits, Look&& look, Bad&& bad) {
    std::vector<Tensor<D, S, Number>> stack;
    stack.push_back(std::move(whole));
    bool doubtful = false;
    for (int parts = 0; !stack.empty(); ++parts) {
        if (parts >= limits.parts) return Verdict::undecided;
        const Tensor<D, S, Number> part = std::move(stack.back());
        stack.pop_back();
        const PartVerdict verdict = look(part);
        if (verdict == PartVerdict::good) continue;
        if (verdict == PartVerdict::bad) {
            bad(part);
            return Verdict::invalid;
        }
        if (verdict == PartVerdict::stuck || part.depth >= limits.depth) {
            doubtful = true;
            continue;
        }
        const int direction = largest_bend(part).direction;
        auto first = half(part, direction, 0);
        auto second = half(part, direction, 1);
        const auto [k0, i0] = lowest_corner(first);
        const auto [k1, i1] = lowest_corner(second);
        if (first.values[k0][corner_coefficients<D>[i0]] < second.values[k1][corner_coefficients<D>[i1]])
            std::swap(first, second);
        stack.push_back(std::move(first));
        stack.push_back(std::move(second));
    }
    return doubtful ? Verdict::undecided : Verdict::valid;
}

/// Bisections after which the places of corners and ends of s are still doubles, exactly: whole multiples of 2⁻⁵².
inline constexpr int exact_places = 52;

/// Where a part lies: weights of the element's vertices at each of its corners, and the ends of s. In integers exact,
/// but for a power of two; in doubles exact for paths up to `exact_places`.
template <int D, class Number>
struct PartPlace {
    std::array<std::array<Number, D + 1>, D + 1> corners{};
    std::array<Number, 2> steps{};
};

template <int D, int S, class Number, class Weight = Number>
[[nodiscard]] PartPlace<D, Weight> place_of(const Tensor<D, S, Number>& part) {
    PartPlace<D, Weight> place;
    for (int i = 0; i <= D; ++i) place.corners[i][i] = 1;
    place.steps[1] = 1;
    for (int n = 0; n < part.depth; ++n) {
        const int direction = part.path[n] / 2;
        const int side = part.path[n] % 2;
        if (direction < step_direction<D>) {
            const int from = local_edges<D>[direction][side];
            const int to = local_edges<D>[direction][1 - side];
            for (int v = 0; v <= D; ++v) place.corners[from][v] += place.corners[to][v];
            for (int i = 0; i <= D; ++i)
                for (int v = 0; v <= D; ++v)
                    place.corners[i][v] = Halving<Weight>::of(place.corners[i][v], i == from, 1);
        } else {
            place.steps[1 - side] += place.steps[side];
            for (int e = 0; e < 2; ++e) place.steps[e] = Halving<Weight>::of(place.steps[e], e != side, 1);
        }
    }
    return place;
}

}  // namespace camber
