module;
#include <cstdint>
#include <optional>
export module camber.validity:verdict;
import camber.core;
import camber.bezier;
import :coefficients;
import :jacobian;

export namespace camber {

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

}  // namespace camber
