// Quadrature rules: Gauss–Jacobi, conical and their products.
module;
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>
module camber.bezier;
import camber.core;
import :lagrange;
import :quadrature;

namespace camber {

namespace {

struct Jacobi {
    double value = 0, derivative = 0;
};

/// P_n^(a, 0) and its derivative at x in (−1, 1), by the three-term recurrence.
Jacobi jacobi(int n, double a, double x) {
    double before = 1, value = (a + (a + 2) * x) / 2;
    for (int k = 1; k < n; ++k) {
        const double s = 2 * k + a;
        const double next = ((s + 1) * (a * a + s * (s + 2) * x) * value - 2 * (k + a) * k * (s + 2) * before) /
                            (2 * (k + 1) * (k + a + 1) * s);
        before = value;
        value = next;
    }
    const double s = 2 * n + a;
    return {value, (n * (a - s * x) * value + 2 * (n + a) * n * before) / (s * (1 - x * x))};
}

}  // namespace

GaussJacobi gauss_jacobi(int n, int power) {
    GaussJacobi rule;
    std::vector<double> roots;
    for (int i = 0; i < n; ++i) {
        double x = -cos(std::numbers::pi * (2 * i + 1) / (2 * n));
        if (i > 0) x = (x + roots.back()) / 2;
        for (int step = 0; step < 100; ++step) {
            const Jacobi p = jacobi(n, power, x);
            double deflation = 0;
            for (const double root : roots) deflation += 1 / (x - root);
            const double move = p.value / (p.derivative - p.value * deflation);
            x -= move;
            if (std::abs(move) < 1e-16) break;
        }
        roots.push_back(x);
        const double slope = jacobi(n, power, x).derivative;
        rule.nodes.push_back((1 + x) / 2);
        rule.weights.push_back(1 / ((1 - x * x) * slope * slope));
    }
    return rule;
}

template <int D>
std::vector<RulePoint<D>> conical_rule(int n) {
    // Adds one direction at a time: ξ_d is t times the remainder 1 − Σ of the previous ξ. The last remainder is ξ_0.
    std::vector<RulePoint<D>> rule(1);
    rule[0].xi[0] = 1;
    for (int d = D - 1; d >= 0; --d) {
        const GaussJacobi line = gauss_jacobi(n, d);
        std::vector<RulePoint<D>> finer;
        for (const RulePoint<D>& point : rule)
            for (std::size_t i = 0; i < line.nodes.size(); ++i) {
                RulePoint<D> next = point;
                next.weight *= line.weights[i];
                next.xi[d + 1] = point.xi[0] * line.nodes[i];
                next.xi[0] = point.xi[0] * (1 - line.nodes[i]);
                finer.push_back(next);
            }
        rule = std::move(finer);
    }
    return rule;
}

template <Shape shape>
    requires(shape != Shape::pyramid)
std::vector<ReferenceRulePoint> reference_rule(int n) {
    std::vector<ReferenceRulePoint> rule(1);
    int first = 0;
    const auto multiply = [&]<int K>(const std::vector<RulePoint<K>>& factor) {
        std::vector<ReferenceRulePoint> finer;
        for (const ReferenceRulePoint& point : rule)
            for (const RulePoint<K>& of_factor : factor) {
                ReferenceRulePoint next = point;
                next.weight *= of_factor.weight;
                for (int d = 0; d < K; ++d) next.x[first + d] = of_factor.xi[d + 1];
                finer.push_back(next);
            }
        rule = std::move(finer);
        first += K;
    };
    for (const int dimension : factors<shape>) {
        if (dimension == 1) multiply(conical_rule<1>(n));
        if (dimension == 2) multiply(conical_rule<2>(n));
        if (dimension == 3) multiply(conical_rule<3>(n));
    }
    return rule;
}

#define CAMBER_INSTANTIATE(shape) template std::vector<ReferenceRulePoint> reference_rule<Shape::shape>(int);
CAMBER_INSTANTIATE(line)
CAMBER_INSTANTIATE(triangle)
CAMBER_INSTANTIATE(quadrilateral)
CAMBER_INSTANTIATE(tetrahedron)
CAMBER_INSTANTIATE(prism)
CAMBER_INSTANTIATE(hexahedron)
#undef CAMBER_INSTANTIATE
template std::vector<RulePoint<2>> conical_rule<2>(int);
template std::vector<RulePoint<3>> conical_rule<3>(int);

}  // namespace camber
