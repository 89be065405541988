module;
#include <optional>
export module camber.validity:motion;
import camber.core;
import camber.bezier;
import :certificate;
import :jacobian;
import :verdict;

export namespace camber {

/// Where an element in motion fails: at this share of the step, exactly, at this point (weights as in Certificate).
template <int D>
struct MotionWitness {
    double step = 0;
    Barycentric<D> point{};
};

/// Of an element all of whose moments are asked for at once.
template <int D>
struct MotionCertificate {
    Verdict verdict = Verdict::undecided;
    Level level = Level::filter;
    std::optional<MotionWitness<D>> witness;  ///< for invalid motions, unless no doubles lie where it fails
};

/// Nodes move on straight lines, n(s) = (1 − s) from + s to for real s ∈ [0, 1]. Valid: the element is valid (see
/// Verdict) at every s, for the straight element of that s; invalid: at some s it is not; undecided: not to be told. A
/// bound of 0 asks for det J > 0 alone, which is what a motion must not lose. An element stored at a rounded n(s) is
/// another one, certified anew by `certify`; those at both ends are covered.
///
/// det J is a polynomial of degree D in s and in ξ: coefficients of both are bounded, and bisected in both. When a
/// single node moves (a vertex without its edges' nodes, or an edge's node), det J is affine in s, det of the straight
/// element too, and both ends tell all.
template <int D>
[[nodiscard]] MotionCertificate<D> certify_motion(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound);

/// A lower bound of the first s at which the motion fails (1 when it does not), a multiple of `step_resolution`: the
/// motion is certified on [0, step]. 0 when not even the beginning is. Doubles with error bounds; where these blur the
/// end of the range, exact arithmetic tells.
template <int D>
[[nodiscard]] double certified_step(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound);
inline constexpr double step_resolution = 0x1p-20;

/// Parts that the exact bisection of a motion may look at; `exact_depth` in a row.
inline constexpr int exact_motion_parts = 4000;

}  // namespace camber

namespace camber {

/// In integers from the start; `from` and `to` are finite.
template <int D>
[[nodiscard]] MotionCertificate<D> certify_motion_exactly(const NodalSimplex<D>& from, const NodalSimplex<D>& to,
                                                          double bound);

}  // namespace camber
