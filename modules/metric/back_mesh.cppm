module;
#include <array>
#include <cstddef>
#include <cstdint>
export module camber.metric:back_mesh;
import camber.core;
import :spd;

export namespace camber {

/// ∂_i log M, i = 1 … D.
template <int D>
using LogGradient = std::array<Sym<D>, D>;

/// How a point lies in a back mesh.
enum class Placement : std::uint8_t {
    inside,
    outside,  ///< beyond the boundary: its nearest boundary point stands for it
    lost,     ///< not found within the search's limits: the best element seen stands for it
};

/// Where a point lies: an element, and the barycentric coordinates in it of the point, or of the point that stands for
/// it.
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// log M at a point and, where asked for, its gradient in physical coordinates there.
template <int D>
struct FieldSample {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};
    Location<D> location;
};

/// A discrete metric field (paper §1.2): log-metrics at the vertices of a straight mesh, linear in each element,
/// constant along the normal beyond the boundary. An immutable value with all that location needs.
template <int D>
struct BackMesh {
    LinearMesh<D> mesh;
    Column<LogMetric<D>> log_metrics;        ///< at the vertices
    Column<LogGradient<D>> nodal_gradients;  ///< volume-weighted means over the balls: they do not jump
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;  ///< boxes of `boundary`
};

/// Errors: a column whose size is not that of the vertices; an element without neighbours' order (see `neighbours`);
/// stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// ∇u_i of the barycentric coordinates of an element; they sum to zero.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

/// ∂ log M in one element, where it is constant: ∂_i log M = Σ_j ∂_i u_j log M_j.
template <int D>
[[nodiscard]] LogGradient<D> field_gradient(const BackMesh<D>& back, ElementId e);

/// The element that holds p: a walk through neighbours from `hint`, else from the nearest boundary point, from where no
/// boundary hides p. Up to rounding the result does not depend on the hint.
template <int D>
[[nodiscard]] Location<D> locate(const BackMesh<D>& back, const Vec<D>& p, ElementId hint);

/// log M at p.
template <int D>
[[nodiscard]] FieldSample<D> sample_value(const BackMesh<D>& back, const Vec<D>& p, ElementId hint);

/// log M at p with the gradient of the element in which p lies; beyond the boundary, that of the constant continuation.
template <int D>
[[nodiscard]] FieldSample<D> sample_with_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint);

/// log M at p with the recovered gradient: nodal_gradients interpolated, which is continuous across faces.
template <int D>
[[nodiscard]] FieldSample<D> sample_with_recovered_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint);

}  // namespace camber
