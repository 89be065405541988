module;
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
module camber.cavity;
import camber.core;
import :orientation;

namespace camber {

namespace {

/// x as the exact sum of two doubles, the first the larger one.
using Parts = std::array<double, 2>;
Parts exact_sum(double a, double b) {  // Knuth
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}
Parts exact_product(double a, double b) {
    const double p = a * b;
    return {p, std::fma(a, b, -p)};
}

/// A sum of doubles without rounding: parts of rising size that do not overlap (Shewchuk 1997, grow-expansion), so that
/// the last has the sign of all.
template <std::size_t Most>
class ExactSum {
  public:
    void add(double term) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            const auto [sum, rest] = exact_sum(term, parts_[i]);
            term = sum;
            if (rest != 0) parts_[kept++] = rest;
        }
        if (term != 0) parts_[kept++] = term;
        size_ = kept;
    }
    [[nodiscard]] double largest() const { return size_ == 0 ? 0 : parts_[size_ - 1]; }

  private:
    std::array<double, Most> parts_{};
    std::size_t size_ = 0;
};

/// The terms of the determinant: the columns' factors in each order of the rows, and its sign.
template <int D>
struct Permutation {
    std::array<int, D> row;
    double sign;
};
constexpr std::array<Permutation<2>, 2> orders_of(std::array<Permutation<2>, 2>) {
    return {{{{0, 1}, 1}, {{1, 0}, -1}}};
}
constexpr std::array<Permutation<3>, 6> orders_of(std::array<Permutation<3>, 6>) {
    return {{{{0, 1, 2}, 1}, {{1, 2, 0}, 1}, {{2, 0, 1}, 1}, {{0, 2, 1}, -1}, {{2, 1, 0}, -1}, {{1, 0, 2}, -1}}};
}
template <int D>
inline constexpr auto orders = orders_of(std::array<Permutation<D>, D == 2 ? 2 : 6>{});

/// Each of the D edge vectors from corner 0, exactly.
template <int D>
double exact_determinant(const std::array<Vec<D>, D + 1>& p) {
    std::array<std::array<Parts, D>, D> columns{};
    for (int a = 0; a < D; ++a)
        for (int c = 0; c < D; ++c) columns[a][c] = exact_sum(p[a + 1][c], -p[0][c]);
    ExactSum<D == 2 ? 16 : 192> sum;
    for (const auto& [row, sign] : orders<D>)
        for (const double x : columns[0][row[0]])
            for (const double y : columns[1][row[1]])
                for (const double xy : exact_product(sign * x, y)) {
                    if constexpr (D == 2)
                        sum.add(xy);
                    else
                        for (const double z : columns[2][row[2]])
                            for (const double xyz : exact_product(xy, z)) sum.add(xyz);
                }
    return sum.largest();
}

}  // namespace

template <int D>
ExactlySigned exactly_signed_volume(const std::array<Vec<D>, D + 1>& p) {
    double volume = 0;
    double size = 0;  // the same sum of absolute values: what rounding is a share of
    for (const auto& [row, sign] : orders<D>) {
        double product = 1;
        for (int a = 0; a < D; ++a) product *= p[a + 1][row[a]] - p[0][row[a]];
        volume += sign * product;
        size += std::abs(product);
    }
    // Differences, products and sums: less than ten roundings, each of half of ε.
    if (!(std::abs(volume) > 8 * std::numeric_limits<double>::epsilon() * size)) volume = exact_determinant<D>(p);
    return {volume, (volume > 0 ? 1 : 0) - (volume < 0 ? 1 : 0)};
}

template ExactlySigned exactly_signed_volume<2>(const std::array<Vec<2>, 3>&);
template ExactlySigned exactly_signed_volume<3>(const std::array<Vec<3>, 4>&);

}  // namespace camber
