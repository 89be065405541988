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
constexpr int max_steps = 12;

template <int D>
double largest(const Vec<D>& v) {
    double most = 0;
    for (const double x : v.c) most = std::max(most, std::abs(x));
    return most;
}

/// A bound of the rounding error of r − F(ξ) in each coordinate of space: of a sum of that many products.
template <int D>
Vec<D> rounding(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi) {
    Vec<D> bound;
    for (int c = 0; c < D; ++c) {
        double size = std::abs(r[c]);
        for (int i = 1; i <= D; ++i) size += std::abs(xi[i] * element.d[i][c]);
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            size += std::abs(edge_shape<D>(xi, e)) *
                    (std::abs(element.u[e][c]) + std::abs(element.d[i][c]) + std::abs(element.d[j][c]));
        }
        bound[c] = 8 * std::numeric_limits<double>::epsilon() * size;
    }
    return bound;
}

/// Coordinates z of steps from ξ, δ = B z, in which the element looks round: along the normal of its thinnest direction
/// a thickness is 1, and along the layer what bends away by no more than that.
template <int D>
struct Scaled {
    Mat<D> b;                      ///< ∂ξ/∂z, about J⁻¹ Q W
    Mat<D> p;                      ///< W⁻¹ Qᵀ, of the residual
    std::array<Mat<D>, D> second;  ///< of coordinate k of W⁻¹ Qᵀ F: its derivatives by z_a and z_b
};
template <int D>
Mat<D> frame_along(const Vec<D>& direction) {
    Mat<D> q;
    q.column[0] = normalised(direction);
    const Vec<D>& n = q.column[0];
    if constexpr (D == 2) {
        q.column[1] = {{-n[1], n[0]}};
    } else {
        int least = 0;
        for (int c = 1; c < D; ++c)
            if (std::abs(n[c]) < std::abs(n[least])) least = c;
        Vec<D> axis;
        axis[least] = 1;
        q.column[1] = normalised(cross(n, axis));
        q.column[2] = cross(n, q.column[1]);
    }
    return q;
}
template <int D>
Scaled<D> scaled_at(const CurvedSimplex<D, D>& element, const Mat<D>& inverse) {
    Vec<D> steepest;
    for (int i = 0; i < D; ++i) {
        Vec<D> row;
        for (int c = 0; c < D; ++c) row[c] = inverse(i, c);
        if (norm_squared(row) > norm_squared(steepest)) steepest = row;
    }
    const Mat<D> q = frame_along<D>(steepest);
    const Mat<D> steps = inverse * q;  // δ of a unit of length along each axis
    const auto second = element.second();
    const auto bend = [&](const Vec<D>& x, const Vec<D>& y) {
        Vec<D> sum;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) sum += (x[a] * y[b]) * second[a][b];
        return sum;
    };
    Vec<D> w;
    w[0] = 1 / norm(steepest);
    for (int k = 1; k < D; ++k) {
        const double whole = 1 / largest(steps.column[k]);  // the element's length along the axis
        const double off = std::abs(dot(q.column[0], bend(whole * steps.column[k], whole * steps.column[k])));
        w[k] = off > w[0] ? whole * std::sqrt(w[0] / off) : whole;
    }
    Scaled<D> s;
    for (int k = 0; k < D; ++k) {
        s.b.column[k] = w[k] * steps.column[k];
        for (int c = 0; c < D; ++c) s.p(k, c) = q.column[k][c] / w[k];
    }
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            const Vec<D> h = s.p * bend(s.b.column[a], s.b.column[b]);
            for (int k = 0; k < D; ++k) s.second[k](a, b) = h[k];
        }
    return s;
}

template <int D>
double largest_row(const Mat<D>& m) {
    double most = 0;
    for (int i = 0; i < D; ++i) {
        double sum = 0;
        for (int j = 0; j < D; ++j) sum += std::abs(m(i, j));
        most = std::max(most, sum);
    }
    return most;
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
            for (int k = 0; k <= D; ++k) length += (corners[j][k] - corners[i][k]) * (corners[j][k] - corners[i][k]);
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

/// Directions in which a part of an element with the inverse Jacobian A may lie beside a point: the normals of its
/// faces, and, since in a thin one they all look the same way, those across its edges within the layer.
template <int D>
auto directions_of(const Mat<D>& a, const Mat<D>& jacobian) {
    std::array<Vec<D>, D + 1 + (D == 2 ? 1 : edges_per_simplex<D>)> out{};
    Vec<D> normal;
    for (int i = 0; i < D; ++i) {
        for (int c = 0; c < D; ++c) out[i][c] = a(i, c);
        out[D] -= out[i];
        if (norm_squared(out[i]) > norm_squared(normal)) normal = out[i];
    }
    if constexpr (D == 2) {
        out[3] = {{-normal[1], normal[0]}};
    } else {
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            out[D + 1 + k] = cross(normal, i == 0   ? jacobian.column[j - 1]
                                           : j == 0 ? jacobian.column[i - 1]
                                                    : jacobian.column[j - 1] - jacobian.column[i - 1]);
        }
    }
    return out;
}

/// Whether all Bézier points of a part lie on one side of the point in one of some directions.
template <int D>
bool misses(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Part<D>& part, const Mat<D>& a,
            const Mat<D>& jacobian) {
    const Vec<D> error = rounding<D>(element, r, part.centre());
    std::array<Vec<D>, (D + 1) * (D + 2) / 2> offs;
    int n = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = i; j <= D; ++j) offs[n++] = element.blossom(part.corners[i], part.corners[j]) - r;
    for (const Vec<D>& direction : directions_of<D>(a, jacobian)) {
        double slack = 0, low = std::numeric_limits<double>::infinity(), high = -low;
        for (int k = 0; k < D; ++k) slack += 2 * std::abs(direction[k]) * error[k];
        for (const Vec<D>& off : offs) {
            const double side = dot(direction, off);
            low = std::min(low, side);
            high = std::max(high, side);
        }
        if (low > slack || high < -slack) return true;
    }
    return false;
}

}  // namespace

template <int D>
Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                    const Mat<D>& inverse) {
    Root<D> root{.xi = xi};
    const Mat<D> jacobian = jacobian_at(element, xi);
    const Scaled<D> s = scaled_at<D>(element, inverse);
    const Vec<D> residual = s.p * (r - element.point(xi));
    const Vec<D> error = rounding<D>(element, r, xi);
    // T(z) = z + P (r − F(ξ + B z)) maps a ball of radius ρ into itself where Y + Z1 ρ + Z2 ρ²/2 ≤ ρ, and contracts.
    Mat<D> product = s.p * (jacobian * s.b);
    double y = 0, z2 = 0;
    for (int k = 0; k < D; ++k) {
        product(k, k) -= 1;
        double y_k = std::abs(residual[k]), z2_k = 0;
        for (int c = 0; c < D; ++c) {
            y_k += std::abs(s.p(k, c)) * error[c];
            for (int b = 0; b < D; ++b) z2_k += std::abs(s.second[k](c, b));
        }
        y = std::max(y, y_k);
        z2 = std::max(z2, z2_k);
    }
    // What rounding may have done to P J B and to the second derivatives, whose terms may cancel: to a few digits.
    constexpr double epsilon = 16 * D * D * std::numeric_limits<double>::epsilon();
    double terms = 0;
    for (int k = 0; k < D; ++k)
        for (int c = 0; c < D; ++c) {
            double column = 0;
            for (const Vec<D>& d : element.d) column += std::abs(d[c]);
            for (const Vec<D>& u : element.u) column += 8 * std::abs(u[c]);
            terms = std::max(terms, std::abs(s.p(k, c)) * column);
        }
    const double blur = epsilon * terms * largest_row<D>(s.b);
    const double z1 = largest_row<D>(product) + blur;
    z2 = (1 + epsilon) * z2 + blur * largest_row<D>(s.b);
    const double slope = 1 - z1, discriminant = slope * slope - 2 * (1 + epsilon) * y * z2;
    if (!(slope > 0) || !(discriminant > 0)) return root;
    constexpr double inflated = 1 + 1e-9;  // the rounding of these lines
    root.is_proven = true;
    root.radius = inflated * 2 * y / (slope + std::sqrt(discriminant)) * largest_row<D>(s.b);
    const double unique = (slope + std::sqrt(discriminant)) / (inflated * z2);
    root.uniqueness = 0.99 * (1 - z1) * unique / largest_row<D>(s.p * jacobian);
    return root;
}

template <int D>
RootIterate<D> newton(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from) {
    RootIterate<D> at;
    at.xi = from;
    Barycentrics<D> first = from;
    for (int step = 0; step < max_steps; ++step) {
        at.inverse = inverse(jacobian_at(element, at.xi));
        const Vec<D> move = at.inverse * (r - element.point(at.xi));
        if (!is_finite(move)) break;
        at.xi = moved<D>(at.xi, move);
        if (step == 0) first = at.xi;
        at.has_converged = largest(move) < small_step;
        if (at.has_converged) return at;
    }
    at.xi = first;
    return at;
}

template <int D>
Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from) {
    const RootIterate<D> at = newton<D>(element, r, from);
    return at.has_converged ? proven_root<D>(element, r, at.xi, at.inverse) : Root<D>{.xi = at.xi};
}

template <int D>
bool may_hold(const CurvedSimplex<D, D>& element, const Vec<D>& r) {
    Part<D> whole;
    for (int i = 0; i <= D; ++i) whole.corners[i][i] = 1;
    const Mat<D> jacobian = jacobian_at(element, whole.centre());
    const Mat<D> a = inverse(jacobian);
    const bool has_inverse = std::ranges::all_of(a.column, [](const Vec<D>& c) { return is_finite(c); });
    return !misses<D>(element, r, whole, has_inverse ? a : Mat<D>::identity(), jacobian);
}

template <int D>
Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r) {
    constexpr int max_parts = 4000, deepest = 60;
    Part<D> whole;
    for (int i = 0; i <= D; ++i) whole.corners[i][i] = 1;
    std::vector<Part<D>> parts{whole};
    Found<D> found{Membership::not_inside, {}};
    for (int seen = 0; !parts.empty(); ++seen) {
        if (seen == max_parts) return {Membership::undecided, found.root};
        const Part<D> part = parts.back();
        parts.pop_back();
        const Mat<D> jacobian = jacobian_at(element, part.centre());
        const Mat<D> a = inverse(jacobian);
        const bool has_inverse = std::ranges::all_of(a.column, [](const Vec<D>& c) { return is_finite(c); });
        if (misses<D>(element, r, part, has_inverse ? a : Mat<D>::identity(), jacobian)) continue;
        Root<D> root;
        // What Newton's method finds from a part's centre it mostly finds from those of its halves.
        if (part.depth % 3 == 0) root = newton_root<D>(element, r, part.centre());
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

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Root<D> proven_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&, const Mat<D>&); \
    template RootIterate<D> newton<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&);              \
    template Root<D> newton_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&);                \
    template bool may_hold<D>(const CurvedSimplex<D, D>&, const Vec<D>&);                                              \
    template Found<D> find_in_element<D>(const CurvedSimplex<D, D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
