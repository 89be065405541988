module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
module camber.metric;
import :curved_simplex;
import :element_frame;
import :quadratic_root;
import camber.core;

namespace camber {

namespace {

/// Newton's method ends below this step: what is left is its square.
constexpr double small_step = 1e-6;
constexpr int most_steps = 12;

template <int D>
double largest(const Vec<D>& v) {
    double most = 0;
    for (const double x : v.c) most = std::max(most, std::abs(x));
    return most;
}

/// Bounds of the rounding errors of F(ξ) and, divided by |δξ|, of its Jacobian, in each coordinate of space.
template <int D>
Vec<D> rounding(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi) {
    double m = 1;
    for (const double u : xi) m = std::max(m, std::abs(u));
    Vec<D> bound;
    for (int c = 0; c < D; ++c) {
        double size = 0;
        for (const Vec<D>& d : element.d) size += std::abs(d[c]);
        for (const Vec<D>& u : element.u) size += 8 * std::abs(u[c]);
        bound[c] = 16 * std::numeric_limits<double>::epsilon() * (std::abs(r[c]) + (1 + m) * (1 + m) * size);
    }
    return bound;
}

/// A part of the reference simplex by its corners.
template <int D>
struct Part {
    std::array<Barycentrics<D>, D + 1> corners{};
    int depth = 0;

    [[nodiscard]] Barycentrics<D> centre() const {
        Barycentrics<D> c{};
        for (const auto& corner : corners)
            for (int i = 0; i <= D; ++i) c[i] += corner[i] / (D + 1);
        return c;
    }
    [[nodiscard]] bool is_within(const Barycentrics<D>& xi, double radius) const {
        return std::ranges::all_of(corners, [&](const Barycentrics<D>& corner) {
            for (int i = 1; i <= D; ++i)
                if (!(std::abs(corner[i] - xi[i]) < radius)) return false;
            return true;
        });
    }
    /// Halves at the longest edge.
    [[nodiscard]] std::array<Part, 2> halves() const {
        int from = 0, to = 1;
        double longest = -1;
        for (const auto& [i, j] : local_edges<D>) {
            double length = 0;
            for (int k = 0; k <= D; ++k)
                length += (corners[j][k] - corners[i][k]) * (corners[j][k] - corners[i][k]);
            if (length > longest) {
                longest = length;
                from = i;
                to = j;
            }
        }
        std::array<Part, 2> out{*this, *this};
        Barycentrics<D> middle{};
        for (int k = 0; k <= D; ++k) middle[k] = 0.5 * (corners[from][k] + corners[to][k]);
        out[0].corners[to] = out[1].corners[from] = middle;
        out[0].depth = out[1].depth = depth + 1;
        return out;
    }
};

/// Whether all Bézier points of a part, seen through A, lie on one side of the point in some coordinate.
template <int D>
bool misses(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Part<D>& part, const Mat<D>& a) {
    const Vec<D> error = rounding<D>(element, r, part.centre());
    Vec<D> low, high;
    for (int c = 0; c < D; ++c) {
        low[c] = std::numeric_limits<double>::infinity();
        high[c] = -low[c];
    }
    for (int i = 0; i <= D; ++i)
        for (int j = i; j <= D; ++j) {
            const Vec<D> g = a * (element.blossom(part.corners[i], part.corners[j]) - r);
            for (int c = 0; c < D; ++c) {
                low[c] = std::min(low[c], g[c]);
                high[c] = std::max(high[c], g[c]);
            }
        }
    for (int c = 0; c < D; ++c) {
        double slack = 0;
        for (int k = 0; k < D; ++k) slack += 2 * std::abs(a(c, k)) * error[k];
        if (low[c] > slack || high[c] < -slack) return true;
    }
    return false;
}

}  // namespace

template <int D>
Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                    const Mat<D>& inverse) {
    Root<D> root{.xi = xi};
    const Vec<D> residual = r - element.point(xi);
    const Mat<D> product = inverse * jacobian_at(element, xi);
    const auto second = element.second();
    const Vec<D> error = rounding<D>(element, r, xi);
    // T(δ) = δ + A (r − F(ξ + δ)) maps a ball of radius ρ into itself where Y + Z1 ρ + Z2 ρ²/2 ≤ ρ, and contracts.
    double y = 0, z1 = 0, z2 = 0;
    for (int i = 0; i < D; ++i) {
        double y_i = 0, z1_i = 0, z2_i = 0, slack = 0;
        for (int k = 0; k < D; ++k) slack += std::abs(inverse(i, k)) * error[k];
        for (int k = 0; k < D; ++k) {
            y_i += inverse(i, k) * residual[k];
            z1_i += std::abs((i == k ? 1.0 : 0.0) - product(i, k));
        }
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) {
                double h = 0;
                for (int k = 0; k < D; ++k) h += inverse(i, k) * second[a][b][k];
                z2_i += std::abs(h);
            }
        y = std::max(y, std::abs(y_i) + slack);
        z1 = std::max(z1, z1_i + D * slack);
        z2 = std::max(z2, z2_i + D * D * slack);
    }
    constexpr double inflated = 1 + 1e-9;  // the rounding of the sums above
    const double b = 1 - inflated * z1;
    const double discriminant = b * b - 2 * inflated * y * z2;
    if (!(b > 0) || !(discriminant > 0)) return root;
    root.is_proven = true;
    root.radius = inflated * 2 * y / (b + std::sqrt(discriminant));
    root.uniqueness = z2 > 0 ? (b + std::sqrt(discriminant)) / (inflated * z2) : std::numeric_limits<double>::infinity();
    return root;
}

template <int D>
Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from) {
    Root<D> first{.xi = from};
    Barycentrics<D> xi = from;
    for (int step = 0; step < most_steps; ++step) {
        const Mat<D> a = inverse(jacobian_at(element, xi));
        const Vec<D> move = a * (r - element.point(xi));
        if (!is_finite(move)) break;
        xi = moved<D>(xi, move);
        if (step == 0) first.xi = xi;
        if (largest(move) < small_step) {
            const Root<D> root = proven_root<D>(element, r, xi, a);
            return root.is_proven ? root : first;
        }
    }
    return first;
}

template <int D>
Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r) {
    constexpr int most_parts = 4000, deepest = 50;
    Part<D> whole;
    for (int i = 0; i <= D; ++i) whole.corners[i][i] = 1;
    std::vector<Part<D>> parts{whole};
    Found<D> found{Membership::not_inside, {}};
    for (int seen = 0; !parts.empty(); ++seen) {
        if (seen == most_parts) return {Membership::undecided, found.root};
        const Part<D> part = parts.back();
        parts.pop_back();
        const Mat<D> a = inverse(jacobian_at(element, part.centre()));
        const bool has_inverse = std::ranges::all_of(a.column, [](const Vec<D>& c) { return is_finite(c); });
        if (misses<D>(element, r, part, has_inverse ? a : Mat<D>::identity())) continue;
        const Root<D> root = newton_root<D>(element, r, part.centre());
        if (root.is_inside()) return {Membership::inside, root};
        if (root.is_proven && part.is_within(root.xi, root.uniqueness)) continue;
        if (part.depth == deepest) {
            found.membership = Membership::undecided;
            found.root = root;
            continue;
        }
        const auto halves = part.halves();
        parts.insert(parts.end(), halves.begin(), halves.end());
    }
    return found;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Root<D> proven_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&,        \
                                    const Mat<D>&);                                                           \
    template Root<D> newton_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&);       \
    template Found<D> find_in_element<D>(const CurvedSimplex<D, D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
