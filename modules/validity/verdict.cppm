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

/// A step of de Casteljau's algorithm: c[target] ← (c[target] + c[source]) / 2.
struct Averaging {
    std::uint8_t target, source;
};

/// Number of averagings of a bisection: Σ α_j over the multi-indices.
template <int D>
inline constexpr int averagings = jacobian_coefficients<D> * D / (D + 1);

/// Moves vertex `from` to the midpoint of its edge to `to`, in place. Step r averages coefficients with α_from ≥ r,
/// those with higher α_from first, so that each source still has its previous value.
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

/// bisections<D>[edge][side] gives the half at that end of the edge.
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

/// For each edge i–j and each multi-index γ of degree D − 2: the positions of γ + 2e_i, γ + e_i + e_j and γ + 2e_j.
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

/// Bézier coefficients of det J on a part, and its corners in the element.
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

/// Largest second difference along a local edge. If all second differences vanish, det J is affine with its minimum at
/// a corner.
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

/// Half of a part on side 0 or 1: vertex local_edges[edge][side] moves to the edge midpoint.
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

/// valid: det J / |det of the straight element| ≥ bound and det J > 0 everywhere. invalid: this fails at a point.
/// undecided: neither was determined; treat it as not valid.
enum class Verdict : std::uint8_t { valid, invalid, undecided };

struct ElementValidity {
    Verdict verdict = Verdict::undecided;
    /// Certified lower bound of min det J / |det of the straight element with the same vertices|, at most 1e-3 · max(1,
    /// |minimum|) below the minimum. It is positive if det J > 0 is certified, or 0 where rounding hides the minimum.
    /// For straight elements that are flat within rounding: +∞ if det J > 0 everywhere, else −∞.
    double min_scaled_jacobian = 0;
    /// An inverted straight element may still be valid.
    bool straight_inverted = false;
};

/// Maximum error of `min_scaled_jacobian` relative to max(1, |minimum|).
inline constexpr double scaled_jacobian_tolerance = 1e-3;

/// Decides by the coefficients, then by bisections.
template <int D>
[[nodiscard]] Verdict decide(const BoundedJacobian<D>& jacobian, double bound);

/// Returns the verdict of `certify`, which also uses double-double arithmetic and integers.
template <int D>
[[nodiscard]] Verdict decide(const NodalSimplex<D>& element, double bound);

/// True if rounding in doubles blurs the scaled Jacobian by more than a tenth of its tolerance.
template <class Jacobian>
[[nodiscard]] inline bool blurred(const Jacobian& jacobian) {
    const double straight = jacobian.straight < 0 ? -jacobian.straight : jacobian.straight;
    return !(jacobian.error < 0.1 * scaled_jacobian_tolerance * straight);
}

/// First stage of `decide`, without branches. valid: all coefficients exceed the bound by more than their rounding
/// error. invalid: a vertex coefficient is certainly below the bound.
template <int D>
[[nodiscard]] Verdict decide_by_coefficients(const BoundedJacobian<D>& jacobian, double bound);

/// Returns (smallest coefficient − its error) / |det of the straight element|: a certified lower bound, not always
/// close to the minimum. ±∞ for flat straight elements, as in ElementValidity.
template <int D>
[[nodiscard]] double smallest_scaled_coefficient(const BoundedJacobian<D>& jacobian);

/// Returns a point where the condition of `decide` certainly fails, if one was found.
template <int D>
[[nodiscard]] std::optional<Barycentric<D>> witness(const BoundedJacobian<D>& jacobian, double bound);

/// Judges an element. `bound` refers to det J / |det straight|; negative values count as 0.
template <int D>
[[nodiscard]] ElementValidity check_element(const BoundedJacobian<D>& jacobian, double bound);
template <int D>
[[nodiscard]] ElementValidity check_element(const QuadraticSimplex<D, D>& element, double bound);
template <int D>
[[nodiscard]] ElementValidity check_element(const NodalSimplex<D>& element, double bound);

/// The method that decided, in order of cost.
enum class Level : std::uint8_t {
    filter,     ///< coefficients in doubles with their error bound
    bisection,  ///< doubles with bisections
    twice,      ///< coefficients and bisections in double-double arithmetic
    exact,      ///< integers, without rounding
};
inline constexpr int levels = 4;

template <int D>
struct Certificate {
    Verdict verdict = Verdict::undecided;
    Level level = Level::filter;
    /// For invalid elements: weights w of a point w/Σw where the condition certainly fails. The weights are
    /// non-negative doubles, taken exactly. Their sum is 1 if doubles can represent this, otherwise an integer (weights
    /// 2 and 1 for a third of an edge). Nothing for nodes that are not finite, or if no doubles lie in the failing part
    /// (relative width below 2⁻⁵³, or a single irregular point).
    std::optional<Barycentric<D>> witness;
};

/// Decides validity (see Verdict) for the stored numbers, level by level. Triangles are always decided for a finite
/// bound. Tetrahedra stay undecided only for equality at an inner point that exact bisection does not meet, or beyond
/// `exact_depth` or `exact_parts`. A negative bound counts as 0; nodes that are not finite make the element invalid.
template <int D>
[[nodiscard]] Certificate<D> certify(const NodalSimplex<D>& element, double bound);

/// The same as `certify` of an element, for Bézier points taken as exact.
template <int D>
[[nodiscard]] Certificate<D> certify(const QuadraticSimplex<D, D>& element, double bound);

/// Like `certify`, but uses integers only.
template <int D>
[[nodiscard]] Certificate<D> certify_exactly(const NodalSimplex<D>& element, double bound);
template <int D>
[[nodiscard]] Certificate<D> certify_exactly(const QuadraticSimplex<D, D>& element, double bound);

/// A point where validity fails; exact values, rounded up.
template <int D>
struct Failure {
    Barycentric<D> at{};  ///< weights, see Certificate::witness
    double jacobian = 0;  ///< det J; for a triangle in space, times the length of the straight normal
    double scaled = 0;    ///< det J / |det of the straight element|; if the divisor is 0: +∞, 0 or −∞ by the sign of
                          ///< det J
};

/// Returns a failing point with few binary digits, proved in integers: at `near` if possible, else at the certificate's
/// witness. Nothing if the element is not invalid, or doubles cannot represent the witness.
template <int D>
[[nodiscard]] std::optional<Failure<D>> find_failure(const NodalSimplex<D>& element, double bound,
                                                     const Barycentric<D>& near);

/// Limits of depth and number of parts for tetrahedra at level `exact`.
inline constexpr int exact_depth = 240;
inline constexpr int exact_parts = 20000;

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Certificate<D> certify_in_doubles(const BoundedJacobian<D>& jacobian, double bound);

}  // namespace camber

export namespace camber {

/// Number of verdicts: one per element or, for a standalone surface mesh, per triangle.
template <int D>
[[nodiscard]] inline std::size_t judged_count(const LinearMesh<D>& mesh) {
    return is_standalone_surface(mesh) ? mesh.facets.size() : mesh.elements.size();
}

/// A P2 triangle in space: vertices, then the nodes of the edges 01, 12 and 20.
///
/// The judged quantity is N · n over twice the area of the straight triangle. N = x_u × x_v is the quadratic normal
/// vector, and n is the unit normal of the straight triangle. The quantity is the scaled Jacobian of the projection
/// onto the straight plane, with either orientation. A triangle is valid if it is regular and its normal is nowhere
/// turned by 90° or more from n. A straight triangle without area is invalid.
struct SurfaceTriangle {
    std::array<Vec<3>, quadratic_nodes<2>> nodes{};
};

[[nodiscard]] inline SurfaceTriangle surface_triangle(const QuadraticMesh<3>& mesh,
                                                      std::span<const LagrangeNode<3>> mid_nodes, std::size_t f) {
    SurfaceTriangle t;
    for (int i = 0; i < 3; ++i) t.nodes[i] = mesh.linear.points[mesh.linear.facets.vertices[f][i]];
    for (int e = 0; e < 3; ++e) t.nodes[3 + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return t;
}

/// Returns the coefficients of N · n up to a factor, which also multiplies `straight`.
[[nodiscard]] BoundedJacobian<2> bounded_jacobian(const SurfaceTriangle& triangle);
[[nodiscard]] BoundedJacobian<2> double_double_jacobian(const SurfaceTriangle& triangle);

/// Judges a triangle with all levels, and always decides.
[[nodiscard]] Certificate<2> certify(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] Certificate<2> certify_exactly(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] std::optional<Failure<2>> find_failure(const SurfaceTriangle& triangle, double bound,
                                                     const Barycentric<2>& near);
[[nodiscard]] Verdict decide(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] ElementValidity check_element(const SurfaceTriangle& triangle, double bound);

}  // namespace camber

namespace camber {

template <class Real>
using SurfaceColumns = std::array<std::array<std::array<Real, 3>, 3>, 2>;

/// Σ of d_1[j] × d_2[k] over the ordered pairs (j, k) with e_j + e_k = α. It is multinomial(α)/4 times the coefficient
/// of N.
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
