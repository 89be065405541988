module;
#include <array>
#include <cstddef>
#include <optional>
export module camber.metric:nodal_field;
import camber.core;
import :back_mesh;
import :spd;

/// Metric fields that are given at all nodes of a curved mesh of degree 2, as a mesh that was adapted once has them
/// when it is adapted again.
export namespace camber {

/// log M at the nodes of a mesh of degree 2.
template <int D>
struct NodalLogs {
    Column<LogMetric<D>> vertices;
    Column<LogMetric<D>> mid_nodes;  ///< one an edge
    friend bool operator==(const NodalLogs&, const NodalLogs&) = default;
};

/// A field that is known at the vertices alone: at the nodes the mean of both ends, so that form (4) is the linear one
/// (paper §2.1). Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// The same for a mesh whose elements bend along with axes that turn: at the nodes the mean in the frame of both ends
/// (frame_mean), which keeps sizes.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// The field of form (4) of the paper on the curved elements of a mesh of degree 2, in physical space: at x = F_K(ξ)
///   log M = Σ_i ξ_i L_i + Σ_e 4 ξ_i ξ_j (L_e − (L_i + L_j)/2),
/// which is Σ B_α(ξ) log M_α with the virtual metrics, and Σ φ_α(ξ) log M(P_α^l). The straight mesh of the same
/// vertices is never asked: it need not be valid. A point is inside of an element only with a proof (`root_radius`).
/// Beyond the boundary the nearest point of the curved boundary stands for it. Recovered gradients are linear between
/// means at the vertices over their balls, by volume; edges see the field as it is in space, without the mesh's curves.
/// On a straight mesh with the means of ends at the nodes all answers are those of `make_back_mesh`, to rounding.
/// Errors: columns whose sizes are not those of the vertices and the edges; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// ρ such that F_K(ξ) = p has exactly one solution within ρ of location.xi (each of ξ_1 … ξ_D), in exact arithmetic for
/// the stored nodes: Kantorovich's theorem for a quadratic map with an approximate inverse, all rounding bounded. None
/// where that cannot be shown. A point whose ξ are all above D ρ therefore lies in the element; and in no other where
/// the mesh is one (elements certified valid by camber.validity, no crossing).
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// C = ∫ sqrt(det M) of the field above over the curved elements, by Gauss's rule with five points a direction. Errors:
/// those of make_nodal_back_mesh.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber
