module;
#include <cstddef>
#include <string>
#include <vector>
export module camber.run:unit_mesh;
import camber.core;
import :stages;

/// How near to unit a mesh is in a metric: `camber check --metric`.
export namespace camber::run {

/// Of the straight form of the mesh, in the metric of a file. Lengths and qualities: metric:unit_mesh.
struct UnitMeshReport {
    std::string metric;  ///< the file's name
    std::size_t edges = 0;
    std::size_t unit_edges = 0, short_edges = 0, long_edges = 0;  ///< within 1/√2 and √2, below, above
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 0, mean_quality = 0;
    std::size_t worst_element = 0;  ///< from 1; 0: no element
};

/// The report, and what it counts, one a unique edge and one an element.
struct UnitMesh {
    UnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// Errors: those of log_metrics_of_file.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const MetricFile& metric, const Execution& execution);

/// Lines for a terminal; a JSON object.
[[nodiscard]] std::string unit_mesh_table(const UnitMeshReport& report);
[[nodiscard]] std::string unit_mesh_json(const UnitMeshReport& report);

}  // namespace camber::run
