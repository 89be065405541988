#pragma once
// A known solution given by an expression, and its interpolation error on an element, used by poisson.hpp. The includer
// imports the modules before it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>

#include "poisson_rule.hpp"

namespace poisson {

template <int D>
struct Sample {
    double value = 0;
    Eigen::Matrix<double, D, 1> gradient = Eigen::Matrix<double, D, 1>::Zero();
};

/// Values and gradients of an expression by central differences of 6th order. With a step of a fiftieth of the element
/// height h, the error is (h/50δ)⁶/140 of u/δ if u changes over δ, so 1e-10 for h = δ. An object has state: each thread
/// needs its own.
template <int D>
class Sampler {
  public:
    explicit Sampler(const ScalarExpression<D>& expression) : values_of_(expression.evaluator()) {}

    [[nodiscard]] double value(const Vec<D>& x) const {
        double value = 0;
        values_of_(std::span(&x, 1), std::span(&value, 1));
        return value;
    }

    [[nodiscard]] Sample<D> at(const Vec<D>& x, double step) const {
        constexpr std::array weights{0.75, -0.15, 1.0 / 60};
        std::array<Vec<D>, 1 + 6 * D> places;
        places.fill(x);
        for (int k = 0, n = 1; k < D; ++k)
            for (std::size_t i = 0; i < weights.size(); ++i, n += 2) {
                places[n][k] += static_cast<double>(i + 1) * step;
                places[n + 1][k] -= static_cast<double>(i + 1) * step;
            }
        std::array<double, 1 + 6 * D> values{};
        values_of_(places, values);
        Sample<D> sample{.value = values[0]};
        for (int k = 0, n = 1; k < D; ++k)
            for (std::size_t i = 0; i < weights.size(); ++i, n += 2) {
                const double apart = (places[n][k] - places[n + 1][k]) / (2 * static_cast<double>(i + 1));
                sample.gradient[k] += weights[i] * (values[n] - values[n + 1]) / apart;
            }
        return sample;
    }

  private:
    std::function<void(std::span<const Vec<D>>, std::span<double>)> values_of_;
};

/// Returns a fiftieth of the minimum height of the straight element, or 0 for a flat one.
template <int D>
double step_in(const QuadraticSimplex<D, D>& element) {
    Barycentric<D> middle{};
    middle.fill(1.0 / (D + 1));
    const auto columns = element.derivatives(middle);
    Eigen::Matrix<double, D, D> jacobian;
    for (int a = 0; a < D; ++a)
        for (int k = 0; k < D; ++k) jacobian(k, a) = columns[a][k];
    const Eigen::Matrix<double, D, D> by_place = jacobian.inverse();  // rows: ∇λ_1 … ∇λ_D
    const double steepest = std::max(by_place.rowwise().norm().maxCoeff(), by_place.colwise().sum().norm());
    return 0.02 / steepest;
}

/// Integrals of the interpolation error e = u − Iu of an element.
template <int D>
struct ElementErrors {
    Local<D> load = Local<D>::Zero();     ///< ∫ ∇e·∇φ_i
    Local<D> moments = Local<D>::Zero();  ///< ∫ e φ_i
    double l2 = 0, h1 = 0;                ///< ∫ e², ∫ |∇e|²
    double u_l2 = 0, u_h1 = 0;            ///< ∫ u², ∫ |∇u|²
};

/// Integrates with one rule. `nodal` has the values of u at the nodes of the element. Points with det J = 0 are
/// omitted.
template <int D>
ElementErrors<D> element_errors(const QuadraticSimplex<D, D>& element, const Local<D>& nodal,
                                const Sampler<D>& solution, const Rule<D>& rule) {
    ElementErrors<D> sum;
    const double step = step_in(element);
    for (const auto& point : rule) {
        const auto at = placed(element, point);
        if (at.determinant == 0) continue;
        const double weight = point.weight * std::abs(at.determinant);
        const Sample<D> u = solution.at(at.place, step);
        const double e = u.value - point.basis.dot(nodal);
        const Eigen::Matrix<double, D, 1> slope = u.gradient - at.gradients * nodal;
        sum.load += weight * at.gradients.transpose() * slope;
        sum.moments += weight * e * point.basis;
        sum.l2 += weight * e * e;
        sum.h1 += weight * slope.squaredNorm();
        sum.u_l2 += weight * u.value * u.value;
        sum.u_h1 += weight * u.gradient.squaredNorm();
    }
    return sum;
}

}  // namespace poisson
