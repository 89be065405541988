module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
module camber.crossing:net;
import camber.core;
import camber.bezier;
import :facet;

/// A piece of a facet by its Bézier points, in coordinates of the pair that is looked at, and what it shares with the
/// pieces of the other facet.
namespace camber {

/// The pieces of a pair of facets have a common origin near to both and a unit such that no Bézier point has a
/// coordinate above 1. What rounding does to a coordinate, u = 2⁻⁵³: a node minus the origin errs by u/4 (nodes are
/// below 1/4), a Bézier point by 2 u, and each division adds at most 4 u, for it takes means, which do not magnify
/// errors, of two and two. At most `max_divisions` of them make less than 128 u.
inline constexpr int max_divisions = 24;
inline constexpr double coordinate_blur = 0x1p-46;

/// Edges are divided at this share from their first end: not in the middle, where facets that someone has thought up
/// like to cross, so that no piece would ever have the crossing in its inside. Both shares are exact.
inline constexpr double first_share = 69.0 / 128, second_share = 59.0 / 128;

/// Names of points that pieces share; 0: of none.
using SharedPoint = std::uint64_t;

/// The part of a shared edge that an edge of a piece is.
struct SharedPart {
    std::uint32_t edge = 0;  ///< 0: none
    std::uint32_t part = 1;  ///< 1: all of it; of part p the first is 2 p, the second 2 p + 1
    bool against = false;    ///< the piece's edge runs against the shared one

    [[nodiscard]] SharedPoint division() const { return edge == 0 ? 0 : SharedPoint{edge} << 32U | part; }
    [[nodiscard]] bool same_as(const SharedPart& o) const { return edge != 0 && edge == o.edge && part == o.part; }
    /// Its part at the piece's first or second end of the edge.
    [[nodiscard]] SharedPart at_end(int end) const {
        return {edge, 2 * part + ((end == 1) != against ? 1U : 0U), against};
    }
};

template <int D>
struct Net {
    static constexpr int K = D - 1;
    static constexpr int edges = edges_per_simplex<K>;

    std::array<Vec<D>, quadratic_nodes<K>> control{};  ///< vertices, then edges in the order of `local_edges`
    std::array<SharedPoint, K + 1> corner{};
    std::array<SharedPart, edges> part{};  ///< from the edge's first local vertex to its second
    int divisions = 0;

    [[nodiscard]] const Vec<D>& middle(int e) const { return control[K + 1 + e]; }
    /// P_{e_i+e_j}.
    [[nodiscard]] const Vec<D>& at(int i, int j) const {
        if (i == j) return control[i];
        if constexpr (K == 1)
            return control[2];
        else
            return control[i + j == 1 ? 3 : i + j == 3 ? 4 : 5];
    }
};

template <int D>
[[nodiscard]] inline Box<D> box_of(const Net<D>& net) {
    Box<D> box;
    for (const Vec<D>& p : net.control) box.include(p);
    return box;
}

/// How far a piece may be from the straight simplex of its corners, parameter by parameter: the difference is
/// Σ 2 ξ_i ξ_j (P_ij − (P_i + P_j)/2), and Σ 2 ξ_i ξ_j is at most 1/2 on an edge, 2/3 on a triangle. Rounding included.
template <int D>
[[nodiscard]] inline double sag(const Net<D>& net) {
    double most = 0;
    for (int e = 0; e < Net<D>::edges; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        most = std::max(most, norm(net.middle(e) - midpoint(net.control[i], net.control[j])));
    }
    return (D == 2 ? 0.5 : 2.0 / 3) * most * (1 + 0x1p-40) + 8 * coordinate_blur;
}

/// Where an edge between two corners is divided: the corners' weights.
struct Division {
    double first, second;
    explicit Division(const SharedPart& part)
        : first(part.against ? first_share : second_share), second(part.against ? second_share : first_share) {}
    template <int D>
    [[nodiscard]] Vec<D> of(const Vec<D>& a, const Vec<D>& b) const {
        return first * a + second * b;
    }
};

/// The two parts of a curve.
[[nodiscard]] inline std::array<Net<2>, 2> pieces(const Net<2>& n) {
    const auto& [a, b, c] = n.control;
    const Division at(n.part[0]);
    const Vec<2> left = at.of(a, c), right = at.of(c, b), middle = at.of(left, right);
    Net<2> first{.control = {a, middle, left}, .corner = {n.corner[0], 0}, .part = {}, .divisions = n.divisions + 1};
    Net<2> second{.control = {middle, b, right}, .corner = {0, n.corner[1]}, .part = {}, .divisions = n.divisions + 1};
    return {first, second};
}

/// The edge of a triangle opposite corner i, in `local_edges`.
inline constexpr std::array<int, 3> opposite_edge{1, 2, 0};

/// The four parts of a triangle: at its corners, and the one between them, whose corner i is on the edge opposite
/// corner i. Bézier points of parts are values of the blossom f(a, b), linear in each: f(V_i, V_j) = P_ij.
[[nodiscard]] inline std::array<Net<3>, 4> pieces(const Net<3>& n) {
    const std::array<Division, 3> at{Division(n.part[0]), Division(n.part[1]), Division(n.part[2])};
    std::array<std::array<Vec<3>, 3>, 3> row{};  // f(M_e, V_k), M_e the point at which edge e is divided
    for (int e = 0; e < 3; ++e)
        for (int k = 0; k < 3; ++k) {
            const auto [i, j] = local_edges<2>[e];
            row[e][k] = at[e].of(n.at(i, k), n.at(j, k));
        }
    const auto blossom = [&](int e, int g) {
        const auto [i, j] = local_edges<2>[g];
        return at[g].of(row[e][i], row[e][j]);
    };
    std::array<Net<3>, 4> out;
    Net<3>& inner = out[3];
    inner.divisions = n.divisions + 1;
    for (int i = 0; i < 3; ++i) {
        const int e = opposite_edge[i];
        inner.control[i] = blossom(e, e);
        inner.corner[i] = n.part[e].division();
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        inner.control[3 + e] = blossom(opposite_edge[j], opposite_edge[k]);
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        Net<3>& piece = out[i];
        piece.divisions = n.divisions + 1;
        piece.control[i] = n.control[i];
        piece.corner[i] = n.corner[i];
        piece.control[3 + opposite_edge[i]] = inner.control[3 + opposite_edge[i]];
        for (const int other : {j, k}) {
            const int e = opposite_edge[j + k - other];  // between corners i and `other`
            piece.control[other] = inner.control[j + k - other];
            piece.corner[other] = inner.corner[j + k - other];
            piece.control[3 + e] = row[e][i];
            piece.part[e] = n.part[e].at_end(local_edges<2>[e][0] == i ? 0 : 1);
        }
    }
    return out;
}

/// The facets in the pair's coordinates, and what they share: vertices at one place, and edges of which all nodes are
/// (places, not numbers: so the two sides of a slit share what they have in common). None where a node is not finite.
template <int D>
struct NetPair {
    Net<D> first, second;
    bool same = false;  ///< they share everything
};

template <int D>
[[nodiscard]] inline Net<D> net_of(const NodalFacet<D>& facet, const Vec<D>& origin, double unit) {
    Net<D> net;
    for (int i = 0; i < D; ++i) net.control[i] = (facet.nodes[i] - origin) * unit;
    for (int e = 0; e < Net<D>::edges; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        net.control[D + e] =
            control_point(net.control[i], {(facet.nodes[D + e] - origin) * unit}, net.control[j]).point;
    }
    return net;
}

/// A power of two that brings nodes below 1/4; none where they are not finite or all at one place.
template <int D>
[[nodiscard]] inline std::optional<double> unit_for(const NodalFacet<D>& first, const NodalFacet<D>& second,
                                                    const Vec<D>& origin) {
    double largest = 0;
    for (const auto* facet : {&first, &second})
        for (const Vec<D>& node : facet->nodes) {
            const Vec<D> from = node - origin;
            if (!is_finite(from)) return {};
            for (const double x : from.c) largest = std::max(largest, std::abs(x));
        }
    if (!(largest > 0x1p-900) || largest > 0x1p900) return {};
    return std::ldexp(1.0, -2 - (std::ilogb(largest) + 1));
}

template <int D>
[[nodiscard]] inline std::optional<NetPair<D>> net_pair(const NodalFacet<D>& first, const NodalFacet<D>& second) {
    std::array<int, D> twin{};  // of each vertex of the first: the second's at its place
    twin.fill(-1);
    int shared = 0, shared_edges = 0;
    Vec<D> origin = first.nodes[0];
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            if (first.nodes[i] == second.nodes[j]) {
                if (shared == 0) origin = first.nodes[i];
                twin[i] = j;
                ++shared;
            }
    const auto unit = unit_for(first, second, origin);
    if (!unit) return {};
    NetPair<D> pair{net_of(first, origin, *unit), net_of(second, origin, *unit)};
    for (int i = 0; i < D; ++i)
        if (twin[i] >= 0) pair.first.corner[i] = pair.second.corner[twin[i]] = static_cast<SharedPoint>(i) + 1;
    for (int e = 0; e < Net<D>::edges; ++e)
        for (int f = 0; f < Net<D>::edges; ++f) {
            const auto [a, b] = local_edges<D - 1>[e];
            const auto [c, d] = local_edges<D - 1>[f];
            const bool along = twin[a] == c && twin[b] == d, against = twin[a] == d && twin[b] == c;
            if ((!along && !against) || !(first.nodes[D + e] == second.nodes[D + f])) continue;
            const auto name = static_cast<std::uint32_t>(e) + 1;
            pair.first.part[e] = {name, 1, false};
            pair.second.part[f] = {name, 1, against};
            ++shared_edges;
        }
    pair.same = shared >= D && shared_edges == Net<D>::edges;
    return pair;
}

}  // namespace camber
