module;
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>
export module camber.metric:quadrature;
import camber.core;

export namespace camber {

/// A rule on [0, 1]: ∫ f ≈ Σ w_q f(t_q).
struct Quadrature {
    std::vector<double> t, w;
    [[nodiscard]] std::size_t size() const { return t.size(); }
};

/// The Gauss–Legendre rule of n ≥ 1 points, exact to degree 2n − 1.
[[nodiscard]] inline Quadrature gauss_legendre(int n) {
    Quadrature rule{std::vector<double>(static_cast<std::size_t>(n)), std::vector<double>(static_cast<std::size_t>(n))};
    for (int i = 0; i < n; ++i) {
        double x = cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
        double slope = 1;
        for (int newton = 0; newton < 100; ++newton) {
            // P_n and P_n' by the three-term recurrence.
            double p0 = 1;
            double p1 = x;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1);
            const double step = p1 / slope;
            x -= step;
            if (std::abs(step) < 1e-16) break;
        }
        const auto slot = static_cast<std::size_t>(n - 1 - i);
        rule.t[slot] = (1 + x) / 2;
        rule.w[slot] = 1 / ((1 - x * x) * slope * slope);
    }
    return rule;
}

/// The number of points by which lengths and gains are reported: finer than any rule that is minimised on.
inline constexpr int report_points = 12;

}  // namespace camber
