module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import :jet_polynomial;

namespace camber {

namespace {

using Row = std::vector<double>;

/// Derivatives of higher orders are known less well.
constexpr std::array<double, 4> weight_of_order{1, 0.5, 0.2, 0.05};
/// What nothing determines, the bubble of a tetrahedron of degree 4, is 0.
constexpr double weight_of_nothing = 1e-5;

/// Orders of derivation by each coordinate, of a jet's entries.
template <int D, int K>
std::vector<std::array<int, D>> orders_of_jet() {
    std::vector<std::array<int, D>> all;
    const auto put = [&](auto... by) {
        std::array<int, D> orders{};
        (++orders[static_cast<std::size_t>(by)], ...);
        all.push_back(orders);
    };
    put();
    for (int i = 0; i < D; ++i) put(i);
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) put(i, j);
    if constexpr (K == 3)
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k) put(i, j, k);
    return all;
}

/// The derivative of x^exponent of this order, x = 0 or 1.
double derivative(int exponent, int order, bool is_one) {
    if (exponent < order || (!is_one && exponent > order)) return 0;
    double product = 1;
    for (int i = 0; i < order; ++i) product *= exponent - i;
    return product;
}

/// Householder's factorisation of the rows, taken along by as many right sides.
void triangularise(std::vector<Row>& rows, std::vector<Row>& right, std::size_t columns) {
    for (std::size_t c = 0; c < columns; ++c) {
        double square = 0;
        for (std::size_t r = c; r < rows.size(); ++r) square += rows[r][c] * rows[r][c];
        const double length = rows[c][c] > 0 ? -std::sqrt(square) : std::sqrt(square);
        std::vector<double> v(rows.size(), 0.0);
        for (std::size_t r = c; r < rows.size(); ++r) v[r] = rows[r][c];
        v[c] -= length;
        double of_v = 0;
        for (const double x : v) of_v += x * x;
        if (!(of_v > 0)) continue;
        const auto reflect = [&](std::vector<Row>& all, std::size_t column) {
            double along = 0;
            for (std::size_t r = c; r < all.size(); ++r) along += v[r] * all[r][column];
            for (std::size_t r = c; r < all.size(); ++r) all[r][column] -= 2 * along / of_v * v[r];
        };
        for (std::size_t k = c; k < columns; ++k) reflect(rows, k);
        for (std::size_t k = 0; k < right.front().size(); ++k) reflect(right, k);
    }
}

template <int D, int K>
JetFit<D, K> made_fit() {
    constexpr auto& terms = exponents<D, jet_degree<K>>;
    const auto orders = orders_of_jet<D, K>();
    const std::size_t data = (D + 1) * orders.size();
    std::vector<Row> rows, right;
    for (int v = 0; v <= D; ++v)
        for (const auto& by : orders) {
            int total = 0;
            for (const int order : by) total += order;
            Row row, identity(data, 0.0);
            for (const auto& term : terms) {
                double x = weight_of_order[static_cast<std::size_t>(total)];
                for (int i = 0; i < D; ++i) x *= derivative(term[i], by[i], v == i + 1);
                row.push_back(x);
            }
            identity[rows.size()] = weight_of_order[static_cast<std::size_t>(total)];
            rows.push_back(std::move(row));
            right.push_back(std::move(identity));
        }
    for (std::size_t t = 0; t < terms.size(); ++t) {
        Row row(terms.size(), 0.0);
        row[t] = weight_of_nothing;
        int degree = 0;
        for (const int e : terms[t]) degree += e;
        if (degree < jet_degree<K>) continue;
        rows.push_back(std::move(row));
        right.emplace_back(data, 0.0);
    }
    triangularise(rows, right, terms.size());
    JetFit<D, K> fit{};
    for (std::size_t c = terms.size(); c-- > 0;)
        for (std::size_t k = 0; k < data; ++k) {
            double x = right[c][k];
            for (std::size_t o = c + 1; o < terms.size(); ++o) x -= rows[c][o] * fit[o][k];
            fit[c][k] = x / rows[c][c];
        }
    return fit;
}

}  // namespace

template <int D, int K>
const JetFit<D, K>& jet_fit() {
    static const JetFit<D, K> fit = made_fit<D, K>();
    return fit;
}

template const JetFit<2, 2>& jet_fit<2, 2>();
template const JetFit<2, 3>& jet_fit<2, 3>();
template const JetFit<3, 2>& jet_fit<3, 2>();
template const JetFit<3, 3>& jet_fit<3, 3>();

}  // namespace camber
