module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
export module camber.validity:verdict;
import camber.core;
import camber.bezier;
import :jacobian;

export namespace camber {

/// One averaging of de Casteljau's algorithm: c[target] ← (c[target] + c[source]) / 2.
struct Averaging {
    std::uint8_t target, source;
};

/// Averagings that a bisection takes: Σ α_j over the multi-indices.
template <int D>
inline constexpr int averagings = jacobian_coefficients<D> * D / (D + 1);

/// The averagings that move vertex `from` of a simplex to the middle of its edge to vertex `to`, in place: round r
/// treats the indices with α_from ≥ r, higher α_from first, so that each source is still of the round before.
template <int D>
[[nodiscard]] constexpr std::array<Averaging, averagings<D>> bisection(int from, int to) {
    std::array<Averaging, averagings<D>> steps{};
    int n = 0;
    for (int round = 1; round <= D; ++round)
        for (int power_of = D; power_of >= round; --power_of)
            for (int p = 0; p < jacobian_coefficients<D>; ++p) {
                auto alpha = jacobian_indices<D>[p];
                if (alpha[from] != power_of) continue;
                --alpha[from];
                ++alpha[to];
                steps[n++] = {static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(position<D, D>(alpha))};
            }
    return steps;
}

/// bisections<D>[edge][side]: those that keep the part at that end of the edge.
template <int D>
inline constexpr auto bisections = [] {
    std::array<std::array<std::array<Averaging, averagings<D>>, 2>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto ends = local_edges<D>[e];
        for (int side = 0; side < 2; ++side) table[e][side] = bisection<D>(ends[side], ends[1 - side]);
    }
    return table;
}();

}  // namespace camber

namespace camber {

/// Positions of γ + 2e_i, γ + e_i + e_j, γ + 2e_j for each edge i–j and γ of degree D − 2.
template <int D>
inline constexpr auto second_differences = [] {
    constexpr int rows = node_count<D - 2, D>;
    std::array<std::array<std::array<int, 3>, rows>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int r = 0; r < rows; ++r)
            for (int m = 0; m < 3; ++m) {
                auto alpha = multi_indices<D - 2, D>[r];
                alpha[local_edges<D>[e][0]] += 2 - m;
                alpha[local_edges<D>[e][1]] += m;
                table[e][r][m] = position<D, D>(alpha);
            }
    return table;
}();

}  // namespace camber

export namespace camber {

/// A part of an element: the Bézier coefficients of det J on it, and its corners in the element.
template <int D>
struct JacobianPart {
    std::array<double, jacobian_coefficients<D>> coefficients{};
    std::array<Barycentric<D>, D + 1> corners{};
    int depth = 0;
};

template <int D>
[[nodiscard]] constexpr JacobianPart<D> whole(const BoundedJacobian<D>& jacobian) {
    JacobianPart<D> part{jacobian.coefficients, {}, 0};
    for (int i = 0; i <= D; ++i) part.corners[i][i] = 1;
    return part;
}

/// The local edge along which the coefficients bend most, and by how much. Second differences along the edges determine
/// all of them: where they vanish, det J is affine and its minimum at a corner.
struct Bend {
    int edge = 0;
    double size = 0;
};
template <int D>
[[nodiscard]] inline Bend largest_bend(const JacobianPart<D>& part) {
    Bend bend;
    const auto& c = part.coefficients;
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (const auto& [i, m, j] : second_differences<D>[e]) {
            const double size = std::abs((c[i] - c[m]) + (c[j] - c[m]));
            if (size > bend.size) bend = {e, size};
        }
    return bend;
}

/// The half of a part on one side (0, 1) of the middle of a local edge: vertex local_edges[edge][side] moves there.
template <int D>
[[nodiscard]] inline JacobianPart<D> half(JacobianPart<D> part, int edge, int side) {
    for (const auto [target, source] : bisections<D>[edge][side])
        part.coefficients[target] = 0.5 * (part.coefficients[target] + part.coefficients[source]);
    const int from = local_edges<D>[edge][side];
    const int to = local_edges<D>[edge][1 - side];
    for (int i = 0; i <= D; ++i) part.corners[from][i] = 0.5 * (part.corners[from][i] + part.corners[to][i]);
    ++part.depth;
    return part;
}

/// Of an element: det J / |det of the straight element| ≥ bound and det J > 0 everywhere (valid), somewhere not
/// (invalid), or not to be told within the means tried. Undecided is never good enough.
enum class Verdict : std::uint8_t { valid, invalid, undecided };

/// Verdict and figures of one element.
struct ElementValidity {
    Verdict verdict = Verdict::undecided;
    /// Certified lower bound of min det J / |det of the straight element with the same vertices|, at most 1e-3 · max(1,
    /// |minimum|) below it; not negative where det J > 0 everywhere is certified, and positive there but for what
    /// rounding hides (0: more than 0). Where the straight element is flat to rounding there is no such number: +∞ if
    /// det J > 0 everywhere, −∞ else.
    double min_scaled_jacobian = 0;
    /// The straight element is flat or inverted; this says nothing about the curved one.
    bool straight_inverted = false;
};

/// How far below the minimum `min_scaled_jacobian` may lie, of max(1, |minimum|).
inline constexpr double scaled_jacobian_tolerance = 1e-3;

/// Verdict only. Stages: the coefficients as they are; then bisections.
template <int D>
[[nodiscard]] Verdict decide(const BoundedJacobian<D>& jacobian, double bound);

/// The same for an element, with two stages more where doubles leave it undecided: both again with the sharp
/// coefficients, then integers: the verdict of `certify`.
template <int D>
[[nodiscard]] Verdict decide(const NodalSimplex<D>& element, double bound);

/// Whether rounding in plain doubles blurs the scaled Jacobian by more than a tenth of its tolerance.
template <class Jacobian>
[[nodiscard]] inline bool blurred(const Jacobian& jacobian) {
    const double straight = jacobian.straight < 0 ? -jacobian.straight : jacobian.straight;
    return !(jacobian.error < 0.1 * scaled_jacobian_tolerance * straight);
}

/// The first stage of `decide`, cheap and without branches: valid if all coefficients are above the bound beyond their
/// rounding error, invalid if one that is a value of det J is below it, undecided otherwise.
template <int D>
[[nodiscard]] Verdict decide_by_coefficients(const BoundedJacobian<D>& jacobian, double bound);

/// Smallest coefficient, less its error, over |det of the straight element|: a certified lower bound of the scaled
/// Jacobian, but not always a close one. ±∞ for flat straight elements as in ElementValidity.
template <int D>
[[nodiscard]] double smallest_scaled_coefficient(const BoundedJacobian<D>& jacobian);

/// A point of the element where the condition of `decide` certainly fails; none if none was found.
template <int D>
[[nodiscard]] std::optional<Barycentric<D>> witness(const BoundedJacobian<D>& jacobian, double bound);

/// `bound` is of det J / |det straight|; a negative one counts as 0.
template <int D>
[[nodiscard]] ElementValidity check_element(const BoundedJacobian<D>& jacobian, double bound);
template <int D>
[[nodiscard]] ElementValidity check_element(const QuadraticSimplex<D, D>& element, double bound);
template <int D>
[[nodiscard]] ElementValidity check_element(const NodalSimplex<D>& element, double bound);

/// What decided, from the cheapest on.
enum class Level : std::uint8_t {
    filter,     ///< the coefficients in doubles, with their error bound
    bisection,  ///< doubles too, after bisections
    twice,      ///< both again in numbers of twice the digits
    exact,      ///< integers: no rounding at all
};
inline constexpr int levels = 4;

/// The verdict of an element, what decided it, and where it fails.
template <int D>
struct Certificate {
    Verdict verdict = Verdict::undecided;
    Level level = Level::filter;
    /// For invalid elements: a point where det J > 0 or det J ≥ bound · |det straight| fails for certain, by weights of
    /// the vertices: non-negative doubles, taken exactly; the point is w/Σw. Their sum is 1 wherever the point has such
    /// doubles, and a whole number otherwise (a third of an edge: 2, 1). None for nodes that are not finite, and none
    /// where the part that fails is so small that no doubles lie in it (relative width below 2⁻⁵³, or a single
    /// irregular point).
    std::optional<Barycentric<D>> witness;
};

/// Is the element valid (see Verdict), for the numbers stored in it? Every level that cannot tell hands on to the next.
/// Triangles are always decided (finite bound); tetrahedra stay undecided only where the condition holds, but with
/// equality at some inner point that exact bisection does not meet; or beyond `exact_depth` bisections or `exact_parts`
/// parts. A negative bound counts as 0; nodes that are not finite make the element invalid.
template <int D>
[[nodiscard]] Certificate<D> certify(const NodalSimplex<D>& element, double bound);

/// The same of the element with exactly these Bézier points.
template <int D>
[[nodiscard]] Certificate<D> certify(const QuadraticSimplex<D, D>& element, double bound);

/// The last level alone: in integers from the start.
template <int D>
[[nodiscard]] Certificate<D> certify_exactly(const NodalSimplex<D>& element, double bound);
template <int D>
[[nodiscard]] Certificate<D> certify_exactly(const QuadraticSimplex<D, D>& element, double bound);

/// A point of an element where its condition fails, and by how much: exact values, rounded up.
template <int D>
struct Failure {
    Barycentric<D> at{};  ///< weights, as a certificate's witness
    double jacobian = 0;  ///< det J there; of a triangle in space, times the length of its straight one's normal
    double scaled = 0;    ///< det J over |det of the straight element|; +∞, 0 or −∞, by sign, where that is 0
};

/// A point where an invalid element fails, of as few binary digits as show it, proved in integers: near `near` if it
/// fails there, else near its certificate's witness. None for elements that are not invalid, and where the witness has
/// no doubles.
template <int D>
[[nodiscard]] std::optional<Failure<D>> find_failure(const NodalSimplex<D>& element, double bound,
                                                     const Barycentric<D>& near);

/// Limits of the exact bisection of a tetrahedron: in a row, and parts in all.
inline constexpr int exact_depth = 240;
inline constexpr int exact_parts = 20000;

}  // namespace camber

namespace camber {

/// The first two levels.
template <int D>
[[nodiscard]] Certificate<D> certify_in_doubles(const BoundedJacobian<D>& jacobian, double bound);

}  // namespace camber

export namespace camber {

/// How many verdicts a mesh has: one an element, or one a triangle of a surface alone.
template <int D>
[[nodiscard]] inline std::size_t judged_count(const LinearMesh<D>& mesh) {
    return is_surface_alone(mesh) ? mesh.facets.size() : mesh.elements.size();
}

/// A P2 triangle in space by its Lagrange nodes, as a mesh stores them: the vertices, then the nodes of e01 e12 e20.
///
/// Its normal N = x_u × x_v is quadratic. What is judged is N · n with n the unit normal of the straight triangle of
/// the same vertices, over twice that one's area: the det J of the triangle's shadow in its own straight plane over
/// that of the straight triangle, and in a plane what a triangle in 2D has (of either side: a surface has none). Valid:
/// regular, and nowhere turned by 90° or more from its straight triangle. A straight triangle without area has no
/// normal: invalid.
struct SurfaceTriangle {
    std::array<Vec<3>, quadratic_nodes<2>> nodes{};
};

/// Triangle f of a mesh, with other mid nodes.
[[nodiscard]] inline SurfaceTriangle surface_triangle(const QuadraticMesh<3>& mesh,
                                                      std::span<const LagrangeNode<3>> mid_nodes, std::size_t f) {
    SurfaceTriangle t;
    for (int i = 0; i < 3; ++i) t.nodes[i] = mesh.linear.points[mesh.linear.facets.vertices[f][i]];
    for (int e = 0; e < 3; ++e) t.nodes[3 + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return t;
}

/// The coefficients of N · n up to a factor, which `straight` (N · n of the straight triangle) has too.
[[nodiscard]] BoundedJacobian<2> bounded_jacobian(const SurfaceTriangle& triangle);
[[nodiscard]] BoundedJacobian<2> sharp_jacobian(const SurfaceTriangle& triangle);

/// As of an element: by coefficients, bisections, twice the digits and integers; no triangle stays undecided.
[[nodiscard]] Certificate<2> certify(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] Certificate<2> certify_exactly(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] std::optional<Failure<2>> find_failure(const SurfaceTriangle& triangle, double bound,
                                                     const Barycentric<2>& near);
[[nodiscard]] Verdict decide(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] ElementValidity check_element(const SurfaceTriangle& triangle, double bound);

}  // namespace camber

namespace camber {

/// Its two columns at three vertices.
template <class Real>
using SurfaceColumns = std::array<std::array<std::array<Real, 3>, 3>, 2>;

/// Σ over the ordered ways to write α = e_j + e_k of d_1[j] × d_2[k]: multinomial(α)/4 times the coefficient of N.
template <class Real>
[[nodiscard]] inline std::array<std::array<Real, 3>, jacobian_coefficients<2>> normal_sums(
    const SurfaceColumns<Real>& d) {
    std::array<std::array<Real, 3>, jacobian_coefficients<2>> sums{};
    for (int p = 0; p < jacobian_coefficients<2>; ++p) {
        int j = -1, k = -1;
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < jacobian_indices<2>[p][i]; ++m) (j < 0 ? j : k) = i;
        sums[p] = product(d[0][j], d[1][k]);
        if (j == k) continue;
        const auto other = product(d[0][k], d[1][j]);
        for (int c = 0; c < 3; ++c) sums[p][c] += other[c];
    }
    return sums;
}

}  // namespace camber
