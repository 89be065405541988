module;
#include <cstdint>
#include <span>
#include <tuple>
export module camber.metric:edge_minimiser;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_objective;
import :quadrature;

export namespace camber {

/// How an edge's node is searched for.
struct EdgeMinimiserOptions {
    EdgeObjectiveKind objective = EdgeObjectiveKind::energy;
    EdgeFieldKind field = EdgeFieldKind::back;
    int quadrature_points = 4;
    int max_iterations = 30;
    /// Ends when the model promises to lower the objective by less than this, relatively.
    double tolerance = 1e-7;
    double length_tolerance = 1e-3;     ///< of the length's model
    double max_tangential_shift = 0.2;  ///< at 1/4 the edge folds (l' = 0 at an end)
    double max_offset = 4;              ///< an edge of a mesh that is unit for the metric has length 1

    /// All that a user may set; `objective` is named by whoever offers more than these two.
    [[nodiscard]] static constexpr auto options() {
        using S = EdgeMinimiserOptions;
        return std::tuple(
            option("field", &S::field,
                   "energy and length: metric along the edge: back, from the mesh's vertices all the way; edge, from "
                   "the edge's own three "
                   "values"),
            option("quadrature_points", &S::quadrature_points, "energy and length: Gauss points along an edge")
                .at_least(2)
                .at_most(12),
            option("iterations", &S::max_iterations, "energy and length: largest number of quasi-Newton steps an edge")
                .at_least(0)
                .at_most(1000),
            option("length_tolerance", &S::length_tolerance,
                   "energy only: from its minimum the length is lowered while that promises more than this share; 0: "
                   "never")
                .at_least(0)
                .at_most(1),
            option("max_tangential_shift", &S::max_tangential_shift,
                   "energy and length: how far a node may slide along its edge")
                .unit("chord lengths")
                .at_least(0)
                .below(0.25),
            option("max_offset", &S::max_offset,
                   "energy and length: how far a volume node may leave the middle of its chord")
                .unit("lengths in the metric")
                .above(0));
    }
    friend bool operator==(const EdgeMinimiserOptions&, const EdgeMinimiserOptions&) = default;
};

/// How the node of an edge was found.
enum class EdgeSearch : std::uint8_t {
    converged,  ///< the model's decrease fell below the tolerance
    polished,   ///< stopped at a kink of the back mesh's field, then a pattern search ended it
    exhausted,  ///< out of iterations
};

/// The node found for one edge, and what it makes of its length.
template <int D>
struct EdgeMinimum {
    LagrangeNode<D> node;
    double straight_length = 0;  ///< of the chord, on the true field by report_points
    double length = 0;           ///< of the edge with `node`, likewise; never above straight_length
    EdgeSearch search = EdgeSearch::converged;
    bool shortened = false;  ///< the finer rule found the minimiser's edge longer: its offset was reduced
    bool outside = false;    ///< some sample of the curve lay beyond the back mesh
    bool lost = false;       ///< some sample of the curve was not found in the back mesh
};

/// Rules shared by all edges of a run.
struct EdgeRules {
    Quadrature objective, report;
};
/// The rules that the options ask for: quadrature_points for the search, report_points for the judgement.
[[nodiscard]] EdgeRules edge_rules(const EdgeMinimiserOptions& options);

/// The middle node of P^l = mid + Γ(e, e)/8, Γ(e, e) = M⁻¹[(∂_e M) e − ½ eᵀ(∂M) e]: the first Newton step of the energy
/// from the straight edge (the geodesic equation x'' = −Γ(x', x')), with the recovered gradient of the field at the
/// middle, which does not depend on the back element.
template <int D>
[[nodiscard]] Vec<D> geodesic_start(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02, ElementId hint);

/// The node that makes the edge from p20 to p02 shortest, an edge anywhere in the back mesh: from the better of the
/// straight edge and geodesic_start, BFGS in the metric's own frame, a pattern search where a kink of the field stops
/// it; judged on the true field by the finer rule, by which the result is never longer than the straight edge. `hint`:
/// an element near p20.
template <int D>
[[nodiscard]] EdgeMinimum<D> minimise_edge(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02,
                                           ElementId hint, const EdgeRules& rules, const EdgeMinimiserOptions& options);

/// The same for an edge (a, b) of the back mesh itself, with its shell (not empty). Such a chord lies on kinks of the
/// field: the search starts from the best of the closed-form minima of the shell's sectors, and so does not depend on
/// an order; or from the node that the edge has, where the objective is lower still: it is never longer than that.
template <int D>
[[nodiscard]] EdgeMinimum<D> minimise_back_edge(const BackMesh<D>& back, VertexId a, VertexId b,
                                                const LagrangeNode<D>& present, std::span<const ElementId> shell,
                                                const EdgeRules& rules, const EdgeMinimiserOptions& options);

}  // namespace camber
