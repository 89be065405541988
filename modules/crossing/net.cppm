module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
module camber.crossing:net;
import camber.core;
import camber.bezier;
import :crossings;

/// A piece of a facet: Bézier points, and features shared with pieces of the other facet.
namespace camber {

/// The coordinates of pieces have an origin close to both facets of the pair, and a unit such that Bézier coordinates
/// are at most 1. Rounding errors, with u = 2⁻⁵³: u/4 for node minus origin (nodes are below 1/4), 2 u for a Bézier
/// point, at most 4 u for each division, because means of two do not amplify errors. The total is below 128 u for
/// `max_divisions`.
inline constexpr int max_divisions = 24;
inline constexpr double coordinate_error = 0x1p-46;

/// Fractions at which an edge is divided; they are exact in binary. The midpoint is not used: facets of constructed
/// inputs often cross there, and then no piece has the crossing in its interior.
inline constexpr double first_share = 69.0 / 128, second_share = 59.0 / 128;

/// Id of a point shared by both facets; 0: none.
using SharedPoint = std::uint64_t;

/// Part of an edge shared by both facets.
struct SharedPart {
    std::uint32_t edge = 0;  ///< 0: none
    std::uint32_t part = 1;  ///< 1: the whole edge; part p is divided into 2 p and 2 p + 1
    bool against = false;    ///< the local edge has the opposite orientation

    [[nodiscard]] SharedPoint division() const { return edge == 0 ? 0 : SharedPoint{edge} << 32U | part; }
    [[nodiscard]] bool same_as(const SharedPart& o) const { return edge != 0 && edge == o.edge && part == o.part; }
    /// Half of this part, at end 0 or 1 of the piece's edge.
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
    std::array<SharedPart, edges> part{};
    int divisions = 0;

    [[nodiscard]] const Vec<D>& middle(int e) const { return control[K + 1 + e]; }
    /// Bézier point P_{e_i+e_j}.
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

/// Bound of the distance between the piece and its straight simplex at equal parameters ξ, rounding included. The
/// difference is Σ 2 ξ_i ξ_j (P_ij − (P_i + P_j)/2) over the edges. Σ 2 ξ_i ξ_j is at most 1/2 on an edge, 2/3 on a
/// triangle.
template <int D>
[[nodiscard]] inline double sag(const Net<D>& net) {
    double most = 0;
    for (int e = 0; e < Net<D>::edges; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        most = std::max(most, norm(net.middle(e) - midpoint(net.control[i], net.control[j])));
    }
    return (D == 2 ? 0.5 : 2.0 / 3) * most * (1 + 0x1p-40) + 8 * coordinate_error;
}

struct Division {
    double first, second;
    explicit Division(const SharedPart& part)
        : first(part.against ? first_share : second_share), second(part.against ? second_share : first_share) {}
    template <int D>
    [[nodiscard]] Vec<D> of(const Vec<D>& a, const Vec<D>& b) const {
        return first * a + second * b;
    }
};

[[nodiscard]] inline std::array<Net<2>, 2> pieces(const Net<2>& n) {
    const auto& [a, b, c] = n.control;
    const Division at(n.part[0]);
    const Vec<2> left = at.of(a, c), right = at.of(c, b), middle = at.of(left, right);
    Net<2> first{.control = {a, middle, left}, .corner = {n.corner[0], 0}, .part = {}, .divisions = n.divisions + 1};
    Net<2> second{.control = {middle, b, right}, .corner = {0, n.corner[1]}, .part = {}, .divisions = n.divisions + 1};
    return {first, second};
}

inline constexpr std::array<int, 3> opposite_edge{1, 2, 0};

/// Divides a triangle into three corner pieces and an inner piece. Corner i of the inner piece is on the edge opposite
/// corner i. Bézier points of the pieces are values of the bilinear blossom f, defined by f(V_i, V_j) = P_ij.
[[nodiscard]] inline std::array<Net<3>, 4> pieces(const Net<3>& n) {
    const std::array<Division, 3> at{Division(n.part[0]), Division(n.part[1]), Division(n.part[2])};
    std::array<std::array<Vec<3>, 3>, 3> row{};  // f(M_e, V_k), where M_e is the division point of edge e
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
            const int e = opposite_edge[j + k - other];
            piece.control[other] = inner.control[j + k - other];
            piece.corner[other] = inner.corner[j + k - other];
            piece.control[3 + e] = row[e][i];
            piece.part[e] = n.part[e].at_end(local_edges<2>[e][0] == i ? 0 : 1);
        }
    }
    return out;
}

/// Two facets in the coordinates of the pair. Shared vertices and edges are found by positions, not ids, because of
/// slits.
template <int D>
struct NetPair {
    Net<D> first, second;
    bool same = false;
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

/// Power of two that scales node differences from `origin` below 1/4. None if a node is not finite or all nodes are
/// equal.
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
    std::array<int, D> twin{};  // for each vertex of the first facet: the second's vertex at the same position
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

/// Planes that separate Bézier nets: an approximate search (Gilbert, Johnson, Keerthi 1988), then a rigorous proof.
namespace camber {

/// A plane with normal n is accepted if n · (P − Q) is above this margin times |n|_1 for all points P, Q. The margin
/// covers two errors `coordinate_error` and the rounding of sums.
inline constexpr double separation_margin = 4 * coordinate_error;

template <int D>
[[nodiscard]] inline double sum_of_sizes(const Vec<D>& n) {
    double sum = 0;
    for (const double x : n.c) sum += std::abs(x);
    return sum;
}

template <int D>
struct GjkSimplex {
    std::array<Vec<D>, D + 1> points{};
    std::size_t size = 0;
};

/// Finds the point of the affine hull of `last` and `others` that is closest to the origin, and returns the weights of
/// `others` in it. None if the points are dependent.
template <int D>
[[nodiscard]] inline std::optional<std::array<double, D>> nearest_weights(const Vec<D>& last,
                                                                          std::span<const Vec<D>> others) {
    const std::size_t m = others.size();
    std::array<std::array<double, D + 1>, D> rows{};
    for (std::size_t i = 0; i < m; ++i) {
        for (std::size_t j = 0; j < m; ++j) rows[i][j] = dot(others[i] - last, others[j] - last);
        rows[i][D] = -dot(others[i] - last, last);
    }
    for (std::size_t p = 0; p < m; ++p) {
        if (!(rows[p][p] > 0)) return {};
        for (std::size_t r = 0; r < m; ++r) {
            if (r == p) continue;
            const double factor = rows[r][p] / rows[p][p];
            for (std::size_t c = p; c < m; ++c) rows[r][c] -= factor * rows[p][c];
            rows[r][D] -= factor * rows[p][D];
        }
    }
    std::array<double, D> weights{};
    for (std::size_t i = 0; i < m; ++i) weights[i] = rows[i][D] / rows[i][i];
    return weights;
}

/// Returns the point of the simplex closest to the origin, and removes the vertices that do not determine it. The last
/// vertex is the newest. None: the simplex contains the origin.
template <int D>
[[nodiscard]] inline std::optional<Vec<D>> nearest_place(GjkSimplex<D>& simplex) {
    const Vec<D> last = simplex.points[simplex.size - 1];
    const std::size_t others = simplex.size - 1;
    GjkSimplex<D> best;
    Vec<D> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t mask = 0; mask < (std::size_t{1} << others); ++mask) {
        GjkSimplex<D> chosen;
        for (std::size_t i = 0; i < others; ++i)
            if ((mask >> i & 1U) != 0) chosen.points[chosen.size++] = simplex.points[i];
        const auto weights = nearest_weights<D>(last, {chosen.points.data(), chosen.size});
        if (!weights) continue;
        double sum = 0;
        bool inside = true;
        Vec<D> place = last;
        for (std::size_t i = 0; i < chosen.size; ++i) {
            inside = inside && (*weights)[i] >= 0;
            sum += (*weights)[i];
            place += (chosen.points[i] - last) * (*weights)[i];
        }
        if (!inside || sum > 1) continue;
        if (chosen.size == D) return {};
        if (norm_squared(place) >= least) continue;
        least = norm_squared(place);
        nearest = place;
        chosen.points[chosen.size++] = last;
        best = chosen;
    }
    simplex = best;
    return nearest;
}

/// Searches a direction n that has positive scalar products with all points of a set. `lowest(n)` returns the point
/// with the minimum product; `proves(n)` tests n rigorously.
template <int D, class Lowest, class Proves>
[[nodiscard]] inline bool finds_direction(Vec<D> start, Lowest&& lowest, Proves&& proves) {
    constexpr int max_tries = 12;
    GjkSimplex<D> simplex;
    Vec<D> n = start;
    for (int i = 0; i < max_tries; ++i) {
        // Products with a smaller n would underflow.
        if (!(norm_squared(n) > 0)) return false;
        if (proves(n)) return true;
        const Vec<D> point = lowest(n);
        // Without progress, the hull contains the origin within rounding.
        if (i > 0 && dot(n, point) >= (1 - 0x1p-30) * norm_squared(n)) return false;
        simplex.points[simplex.size++] = point;
        const auto nearest = nearest_place(simplex);
        if (!nearest || simplex.size == 0) return false;
        n = *nearest;
    }
    return false;
}

/// Tries normals of the straight simplices, and cross products of their edges, for gaps too thin for `finds_direction`.
template <class Try>
[[nodiscard]] inline bool some_normal(const Net<2>& first, const Net<2>& second, Try&& works) {
    const auto normal = [](const Net<2>& net) {
        const Vec<2> along = net.control[1] - net.control[0];
        return Vec<2>{{-along[1], along[0]}};
    };
    return works(normal(first)) || works(normal(second));
}
template <class Try>
[[nodiscard]] inline bool some_normal(const Net<3>& first, const Net<3>& second, Try&& works) {
    const auto edge = [](const Net<3>& net, int i) { return net.control[(i + 1) % 3] - net.control[i]; };
    if (works(cross(edge(first, 0), edge(first, 1))) || works(cross(edge(second, 0), edge(second, 1)))) return true;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (works(cross(edge(first, i), edge(second, j)))) return true;
    return false;
}

template <int D>
[[nodiscard]] inline bool separated(const Net<D>& first, const Net<D>& second) {
    const auto lowest_of = [](const Net<D>& net, const Vec<D>& n) {
        const auto less = [&](const Vec<D>& a, const Vec<D>& b) { return dot(a, n) < dot(b, n); };
        return *std::min_element(net.control.begin(), net.control.end(), less);
    };
    const auto difference = [&](const Vec<D>& n) { return lowest_of(first, n) - lowest_of(second, -n); };
    const auto proves = [&](const Vec<D>& n) {
        return dot(lowest_of(first, n), n) - dot(lowest_of(second, -n), n) > separation_margin * sum_of_sizes(n);
    };
    Vec<D> start;
    for (std::size_t i = 0; i < first.control.size(); ++i) start += first.control[i] - second.control[i];
    return finds_direction<D>(start, difference, proves) || some_normal(first, second, [&](const Vec<D>& n) {
               return norm_squared(n) > 0 && (proves(n) || proves(-n));
           });
}

/// True if a plane through the only shared point (corner i of the first and j of the second) separates all other Bézier
/// points. The distance of a piece from this plane then has the Bernstein coefficient 0 at the shared point and
/// coefficients of one sign elsewhere, so the pieces meet only there.
template <int D>
[[nodiscard]] inline bool separated_at(const Net<D>& first, int i, const Net<D>& second, int j) {
    constexpr std::size_t n_vectors = 2 * (quadratic_nodes<D - 1> - 1);
    std::array<Vec<D>, n_vectors> vectors{}, units{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < first.control.size(); ++k)
        if (k != static_cast<std::size_t>(i)) vectors[count++] = first.control[k] - first.control[i];
    for (std::size_t k = 0; k < second.control.size(); ++k)
        if (k != static_cast<std::size_t>(j)) vectors[count++] = second.control[j] - second.control[k];
    Vec<D> start;
    for (std::size_t k = 0; k < n_vectors; ++k) {
        units[k] = normalised(vectors[k]);
        start += units[k];
    }
    const auto lowest = [&](const Vec<D>& n) {
        const auto less = [&](const Vec<D>& a, const Vec<D>& b) { return dot(a, n) < dot(b, n); };
        return *std::min_element(units.begin(), units.end(), less);
    };
    return finds_direction<D>(start, lowest, [&](const Vec<D>& n) {
        const double margin = separation_margin * sum_of_sizes(n);
        return std::all_of(vectors.begin(), vectors.end(), [&](const Vec<D>& v) { return dot(v, n) > margin; });
    });
}

}  // namespace camber

/// Proof that one triangle, or a pair of triangles with a common edge, does not intersect itself.
namespace camber {

/// A triangle with the base `from`–`to`. `side`: the side of the base, in the parameter plane, on which the triangle
/// is: 1 or −1.
struct Sheet {
    const Net<3>* net = nullptr;
    int from = 0, to = 1, apex = 2;
    double side = 1;
};

/// Derivatives of a sheet's map F at the corners, ∂F/∂s and ∂F/∂t, up to factors. In the parameters s and t, the base
/// goes from (−1, 0) to (1, 0), and the apex is (lean, ±1). The derivatives are affine, so their other values are means
/// of those at the corners.
struct SheetSlopes {
    std::array<Vec<3>, 3> s{}, t{};
};

[[nodiscard]] inline Sheet sheet_of(const Net<3>& net) {
    Sheet longest{&net, 0, 1, 2, 1};
    for (int i = 1; i < 3; ++i) {
        const Sheet other{&net, i, (i + 1) % 3, (i + 2) % 3, 1};
        const auto length = [&](const Sheet& s) { return distance(net.control[s.from], net.control[s.to]); };
        if (length(other) > length(longest)) longest = other;
    }
    return longest;
}

[[nodiscard]] inline SheetSlopes upright_slopes(const Sheet& sheet) {
    SheetSlopes d;
    const Net<3>& net = *sheet.net;
    for (int i = 0; i < 3; ++i) {
        d.s[i] = net.at(i, sheet.to) - net.at(i, sheet.from);
        d.t[i] = sheet.side *
                 ((net.at(i, sheet.apex) - net.at(i, sheet.from)) + (net.at(i, sheet.apex) - net.at(i, sheet.to)));
    }
    return d;
}

[[nodiscard]] inline Vec<3> mean(const std::array<Vec<3>, 3>& v) { return (v[0] + v[1] + v[2]) / 3.0; }

[[nodiscard]] inline Vec<3> perpendicular_part(const Vec<3>& n, const Vec<3>& v) { return v - dot(n, v) * n; }

/// Weighted rows of the matrix A (see `is_graph`), and the sizes of the sheets.
struct Layout {
    Vec<3> along, across;
    double length = 0, weight = 1;
    std::array<double, 2> height{};
    bool fits = false;
};

/// Chooses sizes and leans of the sheets, and the rows of A, in the projection along `view` (0: no projection).
/// Subtracts the leans from the slopes. A bad choice can only make the proof fail.
[[nodiscard]] inline Layout laid_out(std::span<SheetSlopes> slopes, const Vec<3>& view) {
    Layout out;
    for (const SheetSlopes& d : slopes) out.along += perpendicular_part(view, mean(d.s));
    out.length = norm(out.along) / static_cast<double>(slopes.size());
    if (!(out.length > 0)) return out;
    out.along = normalised(out.along);
    for (std::size_t k = 0; k < slopes.size(); ++k) {
        SheetSlopes& d = slopes[k];
        const double lean = std::clamp(dot(out.along, mean(d.t)) / out.length, -1.0, 1.0);
        for (int i = 0; i < 3; ++i) d.t[i] -= lean * d.s[i];
        const Vec<3> upright = perpendicular_part(out.along, perpendicular_part(view, mean(d.t)));
        out.height[k] = norm(upright);
        if (!(out.height[k] > 0)) return out;
        out.across += upright / out.height[k];
    }
    if (!(norm_squared(out.across) > 0)) return out;
    out.across = normalised(out.across);
    double shear = 0, twist = 0;
    for (std::size_t k = 0; k < slopes.size(); ++k)
        for (int i = 0; i < 3; ++i) {
            shear = std::max(shear, std::abs(dot(out.along, slopes[k].t[i])) / out.height[k]);
            twist = std::max(twist, std::abs(dot(out.across, slopes[k].s[i])) / out.length);
        }
    if (shear > 0 && twist > 0) out.weight = std::clamp(shear / twist, 0x1p-40, 0x1p40);
    out.fits = true;
    return out;
}

/// True if A dF + (A dF)ᵀ is positive definite at all corners of the sheets, rounding included (see `is_graph`). Slopes
/// are sums of at most six Bézier points.
[[nodiscard]] inline bool is_definite(std::span<const SheetSlopes> slopes, const Layout& layout) {
    const auto& [along, across, length, weight, heights, fits] = layout;
    const double blur_along = 16 * coordinate_error * sum_of_sizes(along);
    const double blur_across = 16 * coordinate_error * sum_of_sizes(across);
    for (std::size_t k = 0; k < slopes.size(); ++k)
        for (int i = 0; i < 3; ++i) {
            const Vec<3>& s = slopes[k].s[i];
            const Vec<3>& t = slopes[k].t[i];
            const double a = (dot(along, s) - blur_along) / length;
            const double d = weight * ((dot(across, t) - blur_across) / heights[k]);
            const double b = std::abs(dot(along, t) / heights[k] + weight * (dot(across, s) / length)) +
                             blur_along / heights[k] + weight * (blur_across / length);
            if (!(a > 0 && d > 0 && 4 * a * d > b * b * (1 + 0x1p-40))) return false;
        }
    return true;
}

[[nodiscard]] inline Vec<3> bent_direction(std::span<const SheetSlopes> slopes) {
    Vec<3> most;
    for (const SheetSlopes& d : slopes)
        for (const auto& of : {d.s, d.t}) {
            const Vec<3> middle = mean(of);
            for (const Vec<3>& v : of)
                if (norm_squared(v - middle) > norm_squared(most)) most = v - middle;
        }
    return normalised(most);
}

/// Proves that the map F of adjacent sheets is injective. Its parameter domain is convex for |lean| ≤ 1. For points x,
/// y of this domain, (y − x)·A (F(y) − F(x)) = ∫ (y − x)·A dF (y − x). This is positive if A dF + (A dF)ᵀ is positive
/// definite. dF is affine, so tests at the corners suffice. The matrix A is arbitrary; here its weighted rows are along
/// and across the base. The sheets need equal Bézier points on their common edge.
[[nodiscard]] inline bool is_graph(std::span<const Sheet> sheets) {
    std::array<SheetSlopes, 2> slopes{}, leaning{};
    for (std::size_t k = 0; k < sheets.size(); ++k) slopes[k] = upright_slopes(sheets[k]);
    const std::span<const SheetSlopes> all(slopes.data(), sheets.size());
    const auto from = [&](const Vec<3>& view) {
        leaning = slopes;
        const std::span<SheetSlopes> copy(leaning.data(), sheets.size());
        const Layout layout = laid_out(copy, view);
        return layout.fits && is_definite(copy, layout);
    };
    return from(Vec<3>{}) || from(bent_direction(all));
}

}  // namespace camber

/// Proof of crossing: the straight simplices cross, and the intersection is farther from the boundary of each than the
/// sum of the sags. Bending the simplices to the pieces then moves no boundary through a piece, which preserves the
/// signed number of crossings, ±1.
namespace camber {

/// Bound of the error of sums of products of coordinate differences, relative to the product of lengths.
inline constexpr double product_rounding = 0x1p-48;

/// True if p and q are on opposite sides of the line through a and b, at distances above `reach`.
[[nodiscard]] inline bool apart_across(const Vec<2>& p, const Vec<2>& q, const Vec<2>& a, const Vec<2>& b,
                                       double reach) {
    const Vec<2> along = b - a;
    const double length = norm(along);
    const auto height = [&](const Vec<2>& x) { return cross(along, x - a); };
    const auto far = [&](const Vec<2>& x) {
        return std::abs(height(x)) > length * ((1 + 0x1p-40) * reach + product_rounding * norm(x - a));
    };
    return (height(p) > 0) != (height(q) > 0) && far(p) && far(q);
}

[[nodiscard]] inline bool pass_through(const Net<2>& first, const Net<2>& second) {
    const auto& p = first.control;
    const auto& q = second.control;
    const double reach = sag(first) + sag(second);
    return apart_across(p[0], p[1], q[0], q[1], reach) && apart_across(q[0], q[1], p[0], p[1], reach);
}

/// True if the segment p–q intersects the triangle and three distances are above `reach`: those of p and q from the
/// plane, and that of the line p–q from the lines of the triangle's edges.
[[nodiscard]] inline bool pierces(const Vec<3>& p, const Vec<3>& q, const std::array<Vec<3>, 3>& triangle,
                                  double reach) {
    reach *= 1 + 0x1p-40;
    const Vec<3> u = triangle[1] - triangle[0], v = triangle[2] - triangle[0];
    const Vec<3> normal = cross(u, v);
    const double size = norm(u) * norm(v);
    const auto height = [&](const Vec<3>& x) { return dot(normal, x - triangle[0]); };
    const auto far = [&](const Vec<3>& x) {
        return std::abs(height(x)) > norm(normal) * reach + product_rounding * size * (reach + norm(x - triangle[0]));
    };
    if ((height(p) > 0) == (height(q) > 0) || !far(p) || !far(q)) return false;
    const Vec<3> along = q - p;
    int positive = 0;
    for (int i = 0; i < 3; ++i) {
        const Vec<3>& a = triangle[i];
        const Vec<3> edge = triangle[(i + 1) % 3] - a;
        const Vec<3> perpendicular = cross(along, edge);
        const double product = dot(perpendicular, a - p);
        const double scale = norm(along) * norm(edge);
        if (!(std::abs(product) > norm(perpendicular) * reach + product_rounding * scale * (reach + norm(a - p))))
            return false;
        positive += product > 0 ? 1 : 0;
    }
    return positive == 0 || positive == 3;
}

[[nodiscard]] inline bool pass_through(const Net<3>& first, const Net<3>& second) {
    const double reach = sag(first) + sag(second);
    const auto corners = [](const Net<3>& net) {
        return std::array<Vec<3>, 3>{net.control[0], net.control[1], net.control[2]};
    };
    const auto one_way = [&](const std::array<Vec<3>, 3>& p, const std::array<Vec<3>, 3>& q) {
        return pierces(p[0], p[1], q, reach) || pierces(p[1], p[2], q, reach) || pierces(p[2], p[0], q, reach);
    };
    return one_way(corners(first), corners(second)) || one_way(corners(second), corners(first));
}

}  // namespace camber

/// Separation by parabolas: the equation of a quadratic curve's parabola shows on which side other points are. It
/// separates nested arcs without division, even if their gap is much smaller than their sag.
namespace camber {

template <int D>
struct Common {
    int count = 0;
    std::array<int, D> first{}, second{};
};

template <int D>
[[nodiscard]] inline Common<D> common_corners(const Net<D>& first, const Net<D>& second) {
    Common<D> common;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            if (first.corner[i] != 0 && first.corner[i] == second.corner[j] && common.count < D) {
                common.first[common.count] = i;
                common.second[common.count++] = j;
            }
    return common;
}

/// Barycentric coordinates of a point in a curve's control triangle, times twice its area: for the two ends and the
/// middle point. On the parabola, middle² = 4 first second.
struct Areas {
    double first = 0, middle = 0, second = 0;
};

/// Error of an area, from two products of differences below 2 with an error of 2 `coordinate_error` each.
inline constexpr double area_error = 20 * coordinate_error;

[[nodiscard]] inline Areas areas_at(const Net<2>& curve, const Vec<2>& p) {
    const auto& [a, b, m] = curve.control;
    return {cross(m - p, b - p), cross(b - p, a - p), cross(a - p, m - p)};
}

struct BoundedNumber {
    double value = 0, error = 0;
    [[nodiscard]] int sign() const { return value > error ? 1 : value < -error ? -1 : 0; }
    friend BoundedNumber operator+(const BoundedNumber& a, const BoundedNumber& b) {
        return {a.value + b.value, a.error + b.error};
    }
    friend BoundedNumber operator*(double s, const BoundedNumber& a) { return {s * a.value, std::abs(s) * a.error}; }
};

/// Polar form of the parabola's equation middle² − 4 first second.
[[nodiscard]] inline BoundedNumber polar(const Areas& p, const Areas& q) {
    const double size = std::abs(p.middle) + std::abs(q.middle) +
                        2 * (std::abs(p.first) + std::abs(q.first) + std::abs(p.second) + std::abs(q.second));
    return {p.middle * q.middle - 2 * (p.first * q.second + p.second * q.first),
            1.1 * area_error * (size + 8 * area_error)};
}

/// True if the curve is on one side of the other's parabola, except at common ends. The parabola's equation along the
/// curve is a quartic polynomial, whose Bernstein coefficients must have equal signs. At a common end, the first or
/// last coefficient is 0 and not tested.
[[nodiscard]] inline bool beside_parabola(const Net<2>& curve, const Net<2>& other,
                                          const std::array<bool, 2>& is_common) {
    const Areas a = areas_at(other, curve.control[0]), m = areas_at(other, curve.control[2]),
                b = areas_at(other, curve.control[1]);
    const std::array<int, 5> signs{polar(a, a).sign(), polar(a, m).sign(),
                                   ((2.0 / 3) * polar(m, m) + (1.0 / 3) * polar(a, b)).sign(), polar(m, b).sign(),
                                   polar(b, b).sign()};
    const std::size_t begin = is_common[0] ? 1 : 0, end = is_common[1] ? 4 : 5;
    return signs[2] != 0 &&
           std::all_of(signs.begin() + static_cast<std::ptrdiff_t>(begin),
                       signs.begin() + static_cast<std::ptrdiff_t>(end), [&](int sign) { return sign == signs[2]; });
}

[[nodiscard]] inline bool separated_by_parabola(const Net<2>& first, const Net<2>& second, const Common<2>& common) {
    std::array<bool, 2> of_first{}, of_second{};
    for (int k = 0; k < common.count; ++k) of_first[common.first[k]] = of_second[common.second[k]] = true;
    return beside_parabola(first, second, of_first) || beside_parabola(second, first, of_second);
}

}  // namespace camber
