module;
#include <array>
#include <cstddef>
#include <utility>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

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

/// The corners of 2^D parts of equal size, turned as the whole: one at each vertex, the rest in the middle.
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
            // Around the octahedron's diagonal from edge 02 to edge 13.
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
        // Of the bubbles alone: the linear part has none, and its digits are kept out.
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

}  // namespace camber
