module;
#include <array>
export module camber.metric:edge_barycentric;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_minimiser;
import :edge_objective;

export namespace camber {

/// An edge's objective as a function of the barycentric coordinates of its node in one back element of vertices A_j
/// (paper §2.2.2): u_0 … u_{D−1} free, u_D = 1 − Σ. With P^l = Σ u_j A_j,
///     ∂_i l'(t) = 4(1−2t)(A_i − A_D),   ∂_i log M(P^l) = log M(A_i) − log M(A_D),
/// so no gradient of barycentric coordinates is needed, and none on a curved or surface back mesh either. (The paper's
/// recursion for ∂_i exp(T) prints ∂_i T = 4t(1−t) Σ_j ∂_i u_j M_j, where log M_j is meant, and ∂ exp(2Q) = 2 exp(Q)
/// ∂ exp(Q), which holds only where Q and ∂Q commute: in general ∂(E²) = ∂E E + E ∂E. Both are avoided here by
/// Daletskii–Krein.)
template <int D>
struct BarycentricSample {
    double value = 0;
    Vec<D> gradient;  ///< with respect to u_0 … u_{D−1}
    Sym<D> hessian;   ///< the SPD model, as that of EdgeObjective, in these coordinates
};

/// The objective with its node at u in an element of its back mesh, which must be one of make_back_mesh.
template <int D>
[[nodiscard]] BarycentricSample<D> evaluate_in_element(const EdgeObjective<D>& objective, ElementId element,
                                                       const std::array<double, D + 1>& u);

/// minimise_edge by that formulation: the same objective, start, bounds and judging rule, but the search moves in one
/// back element at a time, stops at the face that a step would cross, and starts again in the element beyond, or along
/// the face where both sides push it there. The node stays in the back mesh, where minimise_edge may leave it for the
/// constant continuation beyond the boundary. It needs straight elements, as make_back_mesh has them: in any other back
/// mesh it is minimise_edge. (For a curved one the node's coordinates ξ would be those of the reference element, and
/// corners and their differences become x(ξ) and its derivatives.)
template <int D>
[[nodiscard]] EdgeMinimum<D> minimise_edge_barycentric(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02,
                                                       ElementId hint, const EdgeRules& rules,
                                                       const EdgeMinimiserOptions& options);

}  // namespace camber
