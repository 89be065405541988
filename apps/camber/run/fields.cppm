module;
#include <optional>
#include <string>
#include <vector>
export module camber.run:fields;
import camber.core;
import camber.io;
import camber.curving;
import camber.metric;
import :state;

namespace camber::run {

/// The fields that a run's end can show on its mesh, for a VTU file; only those that its stages made known. `field`:
/// null where none was made.
///
/// Cells (on facets and feature edges NaN and −1):
/// - `scaled_jacobian`: certified lower bound of min det J / |det straight|; `verdict`: 0 valid, 1 invalid,
///   2 undecided.
///
/// Nodes (vertices and nodes of edges):
/// - `node_kind`: 0 volume, 1 surface, 2 ridge, 3 corner;
/// - `edge_change`: −1 at vertices, else 0 straight, 1 projected, 2 optimised, 3 relaxed, 4 straightened;
/// - `curvature`: |P^l − M_11|/|P_20 − P_02| of the node's edge; at a vertex the mean of its edges;
/// - `length_reduction`: L_straight/L − 1 of the node's edge, 0 on boundary edges; at a vertex the mean of its volume
/// edges;
/// - `distance_to_geometry` (model units): of boundary nodes from the nearest point of the geometry; NaN in the volume;
/// - `metric` (1/length²): M; at nodes of edges log-Euclidean between the back mesh's vertices.
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<MeshFields> mesh_fields(const Quadratic<D>& end, const BackMesh<D>* field,
                                              const std::optional<EdgeLengths>& lengths, const Execution& execution);

/// Metrics (1/length²) by their logs, one a vertex; those at the vertices of the back mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const Column<LogMetric<D>>& log_metrics, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const Execution& execution);
/// The same at all nodes of a curved mesh, those of the edges after the vertices.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const QuadraticMesh<D>& mesh,
                                                const Execution& execution);

}  // namespace camber::run

export namespace camber::run {

/// A solution's fields at the nodes of its mesh: rows are those of the vertices; the nodes of edges get the mean of the
/// edge's ends, log-Euclidean where both tensors are positive definite. A lone symmetric tensor is called `metric`, a
/// lone size `size`, others `field_1` … Errors: input (rows or dimension are not those of the mesh; `name` is the
/// file's), stopped.
[[nodiscard]] Outcome<MeshFields> solution_fields(const Solution& solution, const std::string& name,
                                                  const AnyMesh& mesh, const Execution& execution);

}  // namespace camber::run
