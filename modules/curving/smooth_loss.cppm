module;
#include <cstddef>
#include <span>
export module camber.curving:smooth_loss;
import camber.core;
import :parts;

export namespace camber {

/// Draws offsets of edges back, in place, until what they add to the error of a smooth function is at most the share
/// `loss` of it, by a model: its third derivatives are even, |∇²u| = ℓ|∇³u| with ℓ the domain's radius of gyration, and
/// the P2 interpolant errs by them on straight edges. An offset d of the edge e adds 24 ∇²u[e, d] to its third
/// derivative along e (see docs/algorithms/smooth-loss.md), in L2 and in H1
///
///   g_e = (24 ℓ |e| |d|)² Σ_K |K|/n (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)),   Σ_e g_e k_e² ≤ (1 + loss)² − 1,   k_e = 1/(1 +
///   (g_e/c)²),
///
/// K: the elements around the edge, of n edges and the smallest height a_K; h² the mean of their squared edges. Offsets
/// are multiplied by k_e with the largest c for which the sum holds: those that cost most per element go first. Returns
/// how many were more than halved. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh with its offsets, one an edge; those of other parts do not count.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of all parts of a mesh: their own offsets are drawn back. How many of those here were more than halved.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber
