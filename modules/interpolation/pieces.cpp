// Integration of errors over elements and their parts.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
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

template <int D, class T>
std::array<T, D> linear_slopes(const Quadratic<D, T>& q) {
    std::array<T, D> slopes{};
    for (int a = 0; a < D; ++a) slopes[a] = q.corners[a + 1] - q.corners[0];
    return slopes;
}

/// Determinant and adjugate of J. Row a of the adjugate is det J ∇ξ_a.
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
    // The derivatives of the second error are those of the first error plus those of the difference of both
    // interpolants, which is a polynomial.
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

template <int D>
std::array<Vec<D>, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides) {
    constexpr std::size_t corners = D + 1;
    std::array<Vec<D>, quadratic_nodes<D>> at;
    for (std::size_t i = 0; i < corners; ++i) at[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        at[corners + k] = sides == Sides::curved
                              ? mesh.mid_nodes[mesh.edges.of_elements[e][k]].point
                              : midpoint(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
    }
    return at;
}

namespace {

template <int D>
std::array<double, quadratic_nodes<D>> values_of(const QuadraticMesh<D>& mesh, std::size_t e,
                                                 std::span<const double> nodal) {
    std::array<double, quadratic_nodes<D>> u{};
    for (std::size_t i = 0; i <= D; ++i) u[i] = nodal[mesh.linear.elements.vertices[e][i].index()];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k)
        u[D + 1 + k] = nodal[mesh.linear.points.size() + mesh.edges.of_elements[e][k].index()];
    return u;
}

}  // namespace

template <int D>
Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, std::span<const double> nodal,
                  Integrator<D>& integrator) {
    constexpr std::size_t corners = D + 1, nodes = quadratic_nodes<D>;
    const std::array<Vec<D>, nodes> at = nodes_of(mesh, e, sides);
    std::array<double, nodes> u{};
    Piece<D> piece;
    piece.straight = sides == Sides::straight;
    piece.origin = at[0];
    for (std::size_t i = 0; i < corners; ++i) piece.places.corners[i] = at[i] - at[0];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Vec<D> middle = midpoint(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
        piece.places.bubbles[k] = at[corners + k] - middle;
    }
    if (nodal.empty())
        integrator.evaluate(at, u);
    else
        u = values_of(mesh, e, nodal);
    double largest = 0;
    for (std::size_t i = 0; i < nodes; ++i) largest = std::max(largest, std::abs(u[i]));
    for (std::size_t i = 0; i < corners; ++i) piece.values[0].corners[i] = u[i];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        piece.values[0].bubbles[k] =
            u[corners + k] - (u[static_cast<std::size_t>(i)] + u[static_cast<std::size_t>(j)]) / 2;
    }
    piece.interpolants = piece.straight && nodal.empty() ? 2 : 1;
    if (piece.interpolants == 2) piece.values[1].corners = piece.values[0].corners;

    // Values of u have rounding errors from their evaluation, and from the rounding of coordinates x_k: |x_k| times the
    // slope of u along axis k. Differences of u between nodes give a lower bound of this slope.
    double slope = 0, distant = 0;
    for (std::size_t i = 1; i < nodes; ++i) slope = std::max(slope, std::abs(u[i] - u[0]) / distance(at[i], at[0]));
    for (int c = 0; c < D; ++c) distant = std::max(distant, std::abs(at[0][c]));
    piece.rounding = std::numeric_limits<double>::epsilon() * (2 * largest + slope * distant);
    return piece;
}

template std::array<Vec<2>, 6> nodes_of<2>(const QuadraticMesh<2>&, std::size_t, Sides);
template std::array<Vec<3>, 10> nodes_of<3>(const QuadraticMesh<3>&, std::size_t, Sides);
template Piece<2> piece_of<2>(const QuadraticMesh<2>&, std::size_t, Sides, std::span<const double>, Integrator<2>&);
template Piece<3> piece_of<3>(const QuadraticMesh<3>&, std::size_t, Sides, std::span<const double>, Integrator<3>&);

Squares effective_change(const Integrals& now, const Integrals& before) {
    Squares change{};
    for (std::size_t q = 0; q < change.size(); ++q) {
        const double noise = q % 2 == 0 ? now.l2_rounding : now.h1_rounding;
        const double blur = 4 * (noise + std::sqrt(noise * now.squares[q]));
        change[q] = std::max(0.0, std::abs(now.squares[q] - before.squares[q]) - blur);
    }
    if (now.turned || before.turned) change[1] = change[3] = 0;
    return change;
}

template <int D>
Integrated integrate_parts(const Piece<D>& whole, const Integrals& of_whole, const Squares& enough, int depth,
                           const CollapsedRule<D>& rule, Integrator<D>& integrator) {
    const auto pieces = divided<D>(whole);
    std::array<Integrals, (1U << D)> each_of;
    Integrated sum;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        each_of[k] = integrator.integrate(pieces[k], rule);
        sum.integrals += each_of[k];
        sum.evaluations += rule.count;
    }
    sum.change = effective_change(sum.integrals, of_whole);
    bool small = true;
    Squares less{};
    for (std::size_t q = 0; q < less.size(); ++q) {
        small = small && sum.change[q] <= enough[q];
        less[q] = enough[q] / 4;  // tolerance of a part: a few parts are as rough as the whole, but most are smoother
    }
    if (small || depth <= 1) return sum;
    Integrated finer;
    finer.evaluations = sum.evaluations;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const Integrated part = integrate_parts(pieces[k], each_of[k], less, depth - 1, rule, integrator);
        finer.integrals += part.integrals;
        finer.evaluations += part.evaluations;
        for (std::size_t q = 0; q < less.size(); ++q) finer.change[q] += part.change[q];
    }
    return finer;
}

namespace {

template <int D>
using Corners = std::array<Barycentric<D>, D + 1>;

template <int D>
Barycentric<D> halfway(const Barycentric<D>& a, const Barycentric<D>& b) {
    Barycentric<D> m{};
    for (int i = 0; i <= D; ++i) m[i] = (a[i] + b[i]) / 2;
    return m;
}

double orientation(const std::array<Vec<2>, 2>& edges) { return det(edges[0], edges[1]); }
double orientation(const std::array<Vec<3>, 3>& edges) { return det(edges[0], edges[1], edges[2]); }

/// Corners of the 2^D parts of an element: one part at each vertex, the others in the middle. All have the same volume
/// and orientation.
template <int D>
const std::array<Corners<D>, (1U << D)>& parts() {
    static const auto all = [] {
        std::array<Corners<D>, (1U << D)> list{};
        Corners<D> vertices{};
        for (int i = 0; i <= D; ++i) vertices[i][i] = 1;
        const auto middle = [&](int i, int j) { return halfway<D>(vertices[i], vertices[j]); };
        for (int i = 0; i <= D; ++i)
            for (int j = 0; j <= D; ++j) list[static_cast<std::size_t>(i)][j] = middle(i, j);
        if constexpr (D == 2) {
            list[3] = {middle(0, 1), middle(1, 2), middle(2, 0)};
        } else {
            // The parts in the middle lie around the octahedron's diagonal, from the middle of edge 02 to that of edge
            // 13.
            const std::array<Barycentric<3>, 4> ring{middle(0, 1), middle(1, 2), middle(2, 3), middle(0, 3)};
            for (std::size_t k = 0; k < 4; ++k) list[4 + k] = {middle(0, 2), middle(1, 3), ring[k], ring[(k + 1) % 4]};
        }
        for (Corners<D>& part : list) {
            std::array<Vec<D>, D> edges;
            for (int a = 0; a < D; ++a)
                for (int c = 0; c < D; ++c) edges[a][c] = part[a + 1][c + 1] - part[0][c + 1];
            if (orientation(edges) < 0) std::swap(part[0], part[1]);
        }
        return list;
    }();
    return all;
}

template <int D, class T>
Quadratic<D, T> restricted(const Quadratic<D, T>& whole, const Corners<D>& part) {
    Quadratic<D, T> q;
    for (int i = 0; i <= D; ++i) q.corners[i] = whole.at(part[i]);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        // Only the offsets are evaluated, so that rounding of the linear part does not enter.
        const Quadratic<D, T> bubbles{{}, whole.bubbles};
        q.bubbles[e] = bubbles.at(halfway<D>(part[i], part[j])) - (bubbles.at(part[i]) + bubbles.at(part[j])) * 0.5;
    }
    return q;
}

}  // namespace

template <int D>
std::array<Piece<D>, (1U << D)> divided(const Piece<D>& piece) {
    std::array<Piece<D>, (1U << D)> pieces;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        pieces[k] = piece;
        pieces[k].places = restricted<D>(piece.places, parts<D>()[k]);
        for (std::size_t f = 0; f < static_cast<std::size_t>(piece.interpolants); ++f)
            pieces[k].values[f] = restricted<D>(piece.values[f], parts<D>()[k]);
    }
    return pieces;
}

template std::array<Piece<2>, 4> divided<2>(const Piece<2>&);
template std::array<Piece<3>, 8> divided<3>(const Piece<3>&);

#define CAMBER_INSTANTIATE(D)                                                                      \
    template class Integrator<D>;                                                                  \
    template Integrated integrate_parts<D>(const Piece<D>&, const Integrals&, const Squares&, int, \
                                           const CollapsedRule<D>&, Integrator<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
