module;
#include <cstddef>
#include <span>
#include <string>
#include <vector>
export module camber.run:solution;
import camber.core;
import camber.config;
import camber.io;
import camber.operation;
import camber.transfer;
import :solution_report;

/// Fields that are known on a mesh: the metric that they ask for, and how they go along.
export namespace camber::run {

/// A field at the vertices, or at all nodes, of a mesh.
struct NamedField {
    std::string name;
    FieldKind kind = FieldKind::scalar;
    TransferField field;
};

/// Each component of each field, a value a node.
[[nodiscard]] std::vector<Column<double>> scalars_of(std::span<const NamedField> fields);

/// Those of these names, each once; no names: all. Errors: a name that there is not (usage), with `where`.
[[nodiscard]] Outcome<std::vector<NamedField>> named(std::vector<NamedField> fields,
                                                     const std::vector<std::string>& names, const std::string& where);

/// The mesh as one of degree 2: a straight one elevated. Errors: of another dimension (internal), memory, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> of_degree_2(const AnyMesh& mesh, const Execution& execution);

/// Number of nodes of the mesh in degree 2: its vertices, and one an edge. The nodes of a straight mesh are those of
/// the elevated one. Errors: those of `unique_edges`.
[[nodiscard]] Outcome<std::size_t> nodes_in_degree_2(const AnyMesh& mesh, const Execution& execution);

/// The fields with their values at the vertices alone, as fields of degree 1.
[[nodiscard]] std::vector<NamedField> at_vertices(const AnyMesh& mesh, std::vector<NamedField> fields);

/// The metric that fields ask for: at the vertices of a straight mesh, at all nodes of a curved one. `given`: those
/// that it is intersected with, rows at the vertices. Each component of each field is a function by itself. Errors:
/// those of `metric_of_solution` and of metric files; fields that are not known alike, none of the names (usage).
struct SolutionMetricMade {
    NamedField metric;
    SolutionMetricReport report;
    std::vector<DistanceBound> bounds = {};  ///< of the boundary, by the expected error (MetricOfSolution)
};
[[nodiscard]] Outcome<SolutionMetricMade> metric_of_fields(const AnyMesh& mesh, std::span<const NamedField> fields,
                                                           const config::SolutionMetric& asked,
                                                           std::span<const Solution> given, double ridge_angle,
                                                           const Around& around);

/// The second derivatives of a field of numbers at the vertices, where materials meet the mean of their sides. Errors:
/// those of `recover_derivatives`; no field of numbers (usage).
[[nodiscard]] Outcome<Solution> hessians_of(const AnyMesh& mesh, const NamedField& field, const Execution& execution);

/// The fields of a mesh on another one. Errors: those of `transfer`; meshes of two dimensions (input).
struct TransferredFields {
    std::vector<NamedField> fields;
    TransferReport report;
};
[[nodiscard]] Outcome<TransferredFields> fields_brought_to(const AnyMesh& new_mesh, const AnyMesh& old_mesh,
                                                           std::vector<NamedField> fields,
                                                           const TransferOptions& options, const Around& around);

/// As fields of a mesh file: at the vertices and, of a mesh of degree 2, at the edges' nodes, where a field of degree 1
/// has the means of their ends.
[[nodiscard]] MeshFields as_mesh_fields(const AnyMesh& mesh, std::span<const NamedField> fields);

}  // namespace camber::run
