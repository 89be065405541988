module;
#include <cstdint>
#include <optional>
export module camber.validity:certificate;
import camber.core;
import camber.bezier;
import :jacobian;
import :verdict;

export namespace camber {

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
