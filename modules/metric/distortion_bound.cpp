module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// e^P for entries ≥ 0 by scaling and squaring: sums of what is not negative, so each entry keeps its digits.
template <int D>
Mat<D> exponential_of_nonnegative(Mat<D> p) {
    double largest = 0;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) largest = std::max(largest, p(i, j));
    int squarings = 0;
    for (; largest > 0.125 && squarings < 20; largest /= 2) ++squarings;
    for (Vec<D>& column : p.column) column *= std::ldexp(1.0, -squarings);
    Mat<D> sum = Mat<D>::identity();
    Mat<D> term = sum;
    for (int n = 1; n <= 14; ++n) {
        term = term * p;
        for (int j = 0; j < D; ++j) sum.column[j] += term.column[j] *= 1.0 / n;
    }
    for (int i = 0; i < squarings; ++i) sum = sum * sum;
    return sum;
}

/// A part of the element, seen where the metric at its middle is the identity: M_mid = frameᵀ frame.
template <int D>
struct SeenPart {
    std::array<Mat<D>, D + 1> jacobians;  ///< frame J W⁻¹ at its corners, between which it is linear
    std::array<Sym<D>, D + 1> logs;       ///< log M along the axes of M_mid
    Vec<D> log_values;                    ///< of M_mid
};
template <int D>
using Corners = std::array<Barycentric<D>, D + 1>;

template <int D>
SeenPart<D> seen(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices, const Corners<D>& corners) {
    Barycentric<D> middle{};
    for (const auto& corner : corners)
        for (int i = 0; i <= D; ++i) middle[i] += corner[i] / (D + 1);
    const EigenSystem<D> e = eigen_system(shape_between<D>(vertices, middle));
    SeenPart<D> part;
    part.log_values = e.values;
    const Mat<D> axes = transposed(e.vectors);
    for (int i = 0; i <= D; ++i) {
        part.jacobians[i] = axes * regular_jacobian<D>(nodes, corners[i]);
        for (Vec<D>& column : part.jacobians[i].column)
            for (int a = 0; a < D; ++a) column[a] *= exp(e.values[a] / 2);
        part.logs[i] = congruence(axes, shape_between<D>(vertices, corners[i]));
    }
    return part;
}

/// On the part |M| ≤ this, entry by entry, in the frame: |e^L| ≤ e^P where |L_ab| ≤ P_ab for a ≠ b and L_aa ≤ P_aa (add
/// a constant to the diagonals and compare the series), and L is a mean of those at the corners.
template <int D>
Sym<D> largest_metric(const SeenPart<D>& part) {
    Mat<D> p;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            p(a, b) = a == b ? part.logs[0](a, a) : 0;
            for (const Sym<D>& l : part.logs) p(a, b) = std::max(p(a, b), a == b ? l(a, a) : std::abs(l(a, b)));
        }
    double least = p(0, 0);
    for (int a = 1; a < D; ++a) least = std::min(least, p(a, a));
    for (int a = 0; a < D; ++a) p(a, a) -= least;
    const Mat<D> exponential = exponential_of_nonnegative<D>(p);
    Sym<D> m;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b <= a; ++b)
            m(a, b) = exponential(a, b) * exp(least - (part.log_values[a] + part.log_values[b]) / 2);
    return m;
}

/// The largest Bézier coefficient of a bound of tr(AᵀA) = Σ_ab M_ab S_ab, S = (J W⁻¹)(J W⁻¹)ᵀ in the frame.
template <int D>
double largest_square(const SeenPart<D>& part, const Sym<D>& metric) {
    double largest = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = 0; j <= i; ++j) {
            const Mat<D>& x = part.jacobians[i];
            const Mat<D>& y = part.jacobians[j];
            double square = 0;
            for (int a = 0; a < D; ++a)
                for (int b = 0; b <= a; ++b) {
                    double s = 0;
                    for (int k = 0; k < D; ++k) s += (x(a, k) * y(b, k) + x(b, k) * y(a, k)) / 2;
                    // S_aa is nowhere negative, its coefficients may be.
                    square += metric(a, b) * (a == b ? s : 2 * std::abs(s));
                }
            largest = std::max(largest, square);
        }
    return largest;
}

/// The least Bézier coefficient of det: the mean over the orders of the corners of each multi-index.
template <int D>
double min_determinant(const SeenPart<D>& part) {
    const auto& m = part.jacobians;
    double least = det(m[0]);
    if constexpr (D == 2) {
        for (int i = 0; i <= 2; ++i)
            for (int j = 0; j <= i; ++j)
                least =
                    std::min(least, (det(m[i].column[0], m[j].column[1]) + det(m[j].column[0], m[i].column[1])) / 2);
    } else {
        for (int i = 0; i <= 3; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k) {
                    const auto term = [&](int a, int b, int c) {
                        return det(m[a].column[0], m[b].column[1], m[c].column[2]);
                    };
                    least = std::min(least, (term(i, j, k) + term(j, k, i) + term(k, i, j) + term(i, k, j) +
                                             term(k, j, i) + term(j, i, k)) /
                                                6);
                }
    }
    return least;
}

/// How much A and M change along an edge of the part, relative to A and to M_mid.
template <int D>
double change_along(const SeenPart<D>& part, int i, int j) {
    double of_a = 0, size = 0, of_m = 0;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            const double x = part.jacobians[i](a, b);
            const double y = part.jacobians[j](a, b);
            of_a += (x - y) * (x - y);
            size += x * x + y * y;
            // By the derivative of exp, see spd.
            const double half = (part.log_values[a] - part.log_values[b]) / 2;
            const double change =
                (part.logs[i](a, b) - part.logs[j](a, b)) * (std::abs(half) < 1e-4 ? 1 : sinh(half) / half);
            of_m += change * change;
        }
    return (size > 0 ? of_a / size : 0) + of_m / D;
}
template <int D>
int bent_edge(const SeenPart<D>& part) {
    double largest = -1;
    int bent = 0;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        const double change = change_along<D>(part, i, j);
        if (change > largest) {
            largest = change;
            bent = e;
        }
    }
    return bent;
}

template <int D>
struct Part {
    Corners<D> corners{};
    double bound = -1;
    int edge = 0;
};

template <int D>
Part<D> bounded(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices, const Corners<D>& corners) {
    const SeenPart<D> part = seen<D>(nodes, vertices, corners);
    const double least = min_determinant<D>(part);
    const double square = largest_square<D>(part, largest_metric<D>(part));
    const double size = D == 2 ? least : cbrt(least * least);
    const double bound = D * size / square;
    return {corners, least > 0 && bound >= 0 ? bound : -1, bent_edge<D>(part)};
}

}  // namespace

template <int D>
LeastQuality bound_quality(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                           const BoundEffort& effort) {
    LeastQuality found;
    const auto look = [&](const Barycentric<D>& at) {
        found.attained = std::min(found.attained, quality_at<D>(nodes, vertices, at));
    };
    std::array<Part<D>, max_bisections + 1> parts;  // a heap, the lowest bound first
    std::size_t n = 0;
    const auto higher = [](const Part<D>& a, const Part<D>& b) { return a.bound > b.bound; };
    const auto add = [&](const Corners<D>& corners) {
        parts[n++] = bounded<D>(nodes, vertices, corners);
        std::push_heap(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n), higher);
    };
    Corners<D> whole{};
    for (int i = 0; i <= D; ++i) {
        whole[i][i] = 1;
        look(whole[i]);
    }
    add(whole);
    const int most = std::min(effort.bisections, max_bisections);
    for (int i = 0; i < most; ++i) {
        // Where 1/η ≤ 0 somewhere there is no bound to be had.
        if (found.attained <= 0 || parts[0].bound >= std::min(effort.enough, effort.share * found.attained)) break;
        std::pop_heap(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n), higher);
        const Part<D> part = parts[--n];
        const auto [a, b] = local_edges<D>[part.edge];
        Barycentric<D> middle;
        for (int k = 0; k <= D; ++k) middle[k] = (part.corners[a][k] + part.corners[b][k]) / 2;
        look(middle);
        for (const int end : {a, b}) {
            Corners<D> corners = part.corners;
            corners[end] = middle;
            add(corners);
        }
    }
    found.bound = std::min(parts[0].bound, found.attained);
    return found;
}

#define CAMBER_INSTANTIATE(D) \
    template LeastQuality bound_quality<D>(const QuadraticNodes<D>&, const VertexLogMetrics<D>&, const BoundEffort&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
