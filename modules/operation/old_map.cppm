module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
module camber.operation:old_map;
import camber.core;
import camber.bezier;
import camber.metric;
import :curved_workspace;
import :measures;
import :state;

/// The curves of a cavity before it is emptied: what it removes as maps x(X) = X + Σ 4 λ_i λ_j d_k from straight shapes
/// to curved ones.
namespace camber {

/// The rows of the inverse times the determinant.
[[nodiscard]] inline std::array<Vec<2>, 2> dual(const Mat<2>& m) {
    const auto& [a, b] = m.column;
    return {Vec<2>{{b[1], -b[0]}}, Vec<2>{{-a[1], a[0]}}};
}
[[nodiscard]] inline std::array<Vec<3>, 3> dual(const Mat<3>& m) {
    const auto& [a, b, c] = m.column;
    return {cross(b, c), cross(c, a), cross(a, b)};
}

/// The removed elements as maps but for those of no straight volume; false, and none, where all of them are straight
/// but for rounding.
template <int D>
[[nodiscard]] bool old_elements_of(const Adaptation<D>& r, const std::vector<ElementId>& elements,
                                   std::vector<OldElement<D>>& pieces) {
    pieces.clear();
    const auto is_bent = [&](EdgeId edge) {
        constexpr double rounding = 1e-14;  // of the chord
        const auto& [a, b] = r.mesh.edges[edge];
        const double chord = norm_squared(r.mesh.points[b] - r.mesh.points[a]);
        return norm_squared(offset_of(r.mesh, edge)) > rounding * rounding * chord;
    };
    if (std::ranges::none_of(elements, [&](ElementId e) { return std::ranges::any_of(r.mesh.edges_of[e], is_bent); }))
        return false;
    for (const ElementId e : elements) {
        const QuadraticNodes<D> nodes = nodes_of(r.mesh, e);
        OldElement<D> piece;
        piece.element = e;
        piece.origin = nodes[0];
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = nodes[i + 1] - nodes[0];
        const double volume = det(sides);
        piece.size = std::abs(volume);
        piece.gradients = dual(sides);
        for (Vec<D>& gradient : piece.gradients) gradient = gradient / volume;
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            piece.offsets[k] = nodes[D + 1 + k] - midpoint(nodes[i], nodes[j]);
        }
        if (volume != 0) pieces.push_back(piece);
    }
    return true;
}

/// X in the straight shape of a piece.
template <int D>
[[nodiscard]] std::array<double, D + 1> place_in(const OldElement<D>& piece, const Vec<D>& p) {
    std::array<double, D + 1> xi{};
    xi[0] = 1;
    for (int i = 0; i < D; ++i) {
        xi[i + 1] = dot(piece.gradients[i], p - piece.origin);
        xi[0] -= xi[i + 1];
    }
    return xi;
}

/// x(X) by this piece; from outside of it by its nearest place.
template <int D>
[[nodiscard]] Vec<D> old_map(const OldElement<D>& piece, const Vec<D>& p) {
    std::array<double, D + 1> xi = place_in(piece, p);
    if (*std::ranges::min_element(xi) < 0) {
        double sum = 0;
        for (double& x : xi) sum += x = std::max(x, 0.0);
        for (double& x : xi) x /= sum;
    }
    Vec<D> out = p;
    for (int k = 0; k < edges_per_simplex<D>; ++k) out += edge_shape<D>(xi, k) * piece.offsets[k];
    return out;
}

/// x(X) by the piece in which X is, or is nearest to being.
template <int D>
[[nodiscard]] Vec<D> old_map(const std::vector<OldElement<D>>& pieces, const Vec<D>& p) {
    const OldElement<D>* best = nullptr;
    double most = -std::numeric_limits<double>::infinity();
    for (const OldElement<D>& piece : pieces) {
        const auto xi = place_in(piece, p);
        const double least = *std::ranges::min_element(xi);
        if (!(least > most)) continue;
        most = least;
        best = &piece;
        if (least >= 0) break;
    }
    return best == nullptr ? p : old_map(*best, p);
}

/// Where a simplex of the boundary has a place, so far.
template <int D>
struct OldPlace {
    Vec<D> point;
    int rank = 0;
    /// The least barycentric coordinate: by this it was chosen among those of one rank.
    double least = -std::numeric_limits<double>::infinity();
};
/// x(X) by a K-simplex of the boundary, if that is of a higher rank, or X is nearer to being in it.
template <int D, int K>
void look_at(const std::array<Vec<D>, K + 1>& corners, const std::array<Vec<D>, edges_per_simplex<K>>& nodes,
             const Vec<D>& p, int rank, OldPlace<D>& best) {
    if (rank < best.rank) return;
    std::array<double, K + 1> xi{};
    const Vec<D> u = corners[1] - corners[0];
    const Vec<D> x = p - corners[0];
    if constexpr (K == 1) {
        xi[1] = dot(u, x) / norm_squared(u);
    } else {
        const Vec<D> v = corners[2] - corners[0];
        const Vec<D> n = cross(u, v);  // products of lengths would lose thin facets
        xi[1] = dot(cross(x, v), n) / norm_squared(n);
        xi[2] = dot(cross(u, x), n) / norm_squared(n);
    }
    xi[0] = 1;
    for (int i = 1; i <= K; ++i) xi[0] -= xi[i];
    const double least = *std::ranges::min_element(xi);
    if (!(rank > best.rank ? std::isfinite(least) : least > best.least)) return;  // no area: not finite
    best = {p, rank, least};
    double sum = 0;
    for (double& c : xi) sum += c = std::max(c, 0.0);
    for (int k = 0; k < edges_per_simplex<K>; ++k) {
        const auto [i, j] = local_edges<K>[k];
        best.point += edge_shape<K>(xi, k) / (sum * sum) * (nodes[k] - midpoint(corners[i], corners[j]));
    }
}

}  // namespace camber
