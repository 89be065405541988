module;
#include <cmath>
#include <numbers>
#include <vector>
module camber.interpolation;
import camber.core;

namespace camber {

namespace {

struct Jacobi {
    double value = 0, derivative = 0;
};

/// P_n^(a, 0) and its derivative at x inside (−1, 1), by the three-term recurrence.
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

}  // namespace camber
