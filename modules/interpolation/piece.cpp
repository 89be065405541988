module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

Integrals& Integrals::operator+=(const Integrals& other) {
    for (std::size_t q = 0; q < squares.size(); ++q) squares[q] += other.squares[q];
    l2_rounding += other.l2_rounding;
    h1_rounding += other.h1_rounding;
    turned = turned || other.turned;
    return *this;
}

namespace {

/// Derivatives of a quadratic's linear part by ξ_1 … ξ_D.
template <int D, class T>
std::array<T, D> linear_slopes(const Quadratic<D, T>& q) {
    std::array<T, D> slopes{};
    for (int a = 0; a < D; ++a) slopes[a] = q.corners[a + 1] - q.corners[0];
    return slopes;
}

/// det J and the rows of its adjugate: row a is det J times the gradient of ξ_a.
template <int D>
struct Cofactors {
    std::array<Vec<D>, D> rows;
    double determinant = 0;
    bool singular = false;
};
template <int D>
Cofactors<D> cofactors(const std::array<Vec<D>, D>& columns) {
    Cofactors<D> j;
    double size = 1;
    if constexpr (D == 2) {
        j.rows[0] = {{columns[1][1], -columns[1][0]}};
        j.rows[1] = {{-columns[0][1], columns[0][0]}};
    } else {
        for (int a = 0; a < 3; ++a) j.rows[a] = cross(columns[(a + 1) % 3], columns[(a + 2) % 3]);
    }
    j.determinant = dot(j.rows[0], columns[0]);
    for (int a = 0; a < D; ++a) size *= norm(columns[a]);
    j.singular = !(std::abs(j.determinant) > 1e-14 * size);
    return j;
}

}  // namespace

template <int D>
void Integrator<D>::resize(std::size_t count) {
    points_.resize(count);
    values_.resize(count);
    error_.resize(count);
    other_error_.resize(count);
    for (int a = 0; a < D; ++a) {
        slopes_[a].resize(count);
        for (int c = 0; c < D; ++c) columns_[a][c].resize(count);
    }
}

template <int D>
void Integrator<D>::place(const Piece<D>& piece, const CollapsedRule<D>& rule) {
    const std::size_t count = rule.count;
    const auto slopes = linear_slopes(piece.places);
    const Vec<D> first = piece.places.corners[0];
    for (std::size_t p = 0; p < count; ++p) {
        Vec<D> x = first;
        for (int a = 0; a < D; ++a) x += slopes[a] * rule.barycentric[a + 1][p];
        points_[p] = x;
    }
    if (!piece.straight) {
        for (std::size_t p = 0; p < count; ++p)
            for (int e = 0; e < edges_per_simplex<D>; ++e) points_[p] += piece.places.bubbles[e] * rule.bubbles[e][p];
        for (int a = 0; a < D; ++a)
            for (int c = 0; c < D; ++c) {
                double* column = columns_[a][c].data();
                for (std::size_t p = 0; p < count; ++p) column[p] = slopes[a][c];
                for (int e = 0; e < edges_per_simplex<D>; ++e) {
                    const double bubble = piece.places.bubbles[e][c];
                    const double* slope = rule.bubble_slopes[e][a].data();
                    for (std::size_t p = 0; p < count; ++p) column[p] += bubble * slope[p];
                }
            }
    }
    for (std::size_t p = 0; p < count; ++p) points_[p] += piece.origin;
}

template <int D>
void Integrator<D>::subtract(const Quadratic<D, double>& interpolant, const CollapsedRule<D>& rule,
                             std::vector<double>& error) {
    for (std::size_t p = 0; p < rule.count; ++p) error[p] = values_[p];
    const auto add = [&](double value, const std::vector<double>& shape) {
        for (std::size_t p = 0; p < rule.count; ++p) error[p] -= value * shape[p];
    };
    for (int i = 0; i <= D; ++i) add(interpolant.corners[i], rule.barycentric[i]);
    for (int e = 0; e < edges_per_simplex<D>; ++e) add(interpolant.bubbles[e], rule.bubbles[e]);
}

template <int D>
Integrals Integrator<D>::integrate(const Piece<D>& piece, const CollapsedRule<D>& rule) {
    resize(rule.count);
    place(piece, rule);
    field_(points_, values_);
    subtract(piece.values[0], rule, error_);
    rule.differentiate(error_, slopes_);
    const bool both = piece.interpolants == 2;
    // The second interpolant's error has the derivatives of the first's and of what the two differ in, a polynomial.
    Quadratic<D, double> difference;
    if (both) {
        subtract(piece.values[1], rule, other_error_);
        for (int i = 0; i <= D; ++i) difference.corners[i] = piece.values[0].corners[i] - piece.values[1].corners[i];
        for (int e = 0; e < edges_per_simplex<D>; ++e)
            difference.bubbles[e] = piece.values[0].bubbles[e] - piece.values[1].bubbles[e];
    }
    const auto difference_slopes = linear_slopes(difference);

    Integrals sum;
    const Cofactors<D> affine = cofactors<D>(linear_slopes(piece.places));
    const double noise = piece.rounding * piece.rounding;
    for (std::size_t p = 0; p < rule.count; ++p) {
        Cofactors<D> j = affine;
        if (!piece.straight) {
            std::array<Vec<D>, D> columns;
            for (int a = 0; a < D; ++a)
                for (int c = 0; c < D; ++c) columns[a][c] = columns_[a][c][p];
            j = cofactors<D>(columns);
        }
        const double measure = std::abs(j.determinant);
        const double weight = rule.weights[p];
        sum.turned = sum.turned || !(j.determinant > 0);
        sum.squares[0] += weight * measure * error_[p] * error_[p];
        sum.l2_rounding += weight * measure * noise;
        if (both) sum.squares[2] += weight * measure * other_error_[p] * other_error_[p];
        if (j.singular) continue;
        const double by_measure = weight / measure;
        Vec<D> gradient;
        double amplified = 0;
        for (int a = 0; a < D; ++a) {
            gradient += j.rows[a] * slopes_[a][p];
            amplified += norm_squared(j.rows[a]) * rule.amplification[a][p];
        }
        sum.squares[1] += by_measure * norm_squared(gradient);
        sum.h1_rounding += by_measure * amplified * noise;
        if (!both) continue;
        for (int a = 0; a < D; ++a) {
            double slope = difference_slopes[a];
            for (int e = 0; e < edges_per_simplex<D>; ++e) slope += difference.bubbles[e] * rule.bubble_slopes[e][a][p];
            gradient += j.rows[a] * slope;
        }
        sum.squares[3] += by_measure * norm_squared(gradient);
    }
    return sum;
}

#define CAMBER_INSTANTIATE(D) template class Integrator<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
