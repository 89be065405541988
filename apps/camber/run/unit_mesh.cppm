module;
#include <cstddef>
#include <string>
#include <vector>
module camber.run:unit_mesh;
import camber.core;
import camber.metric;
import :histogram;
import :report;

/// How near to unit a straight mesh is in a metric: `camber check --metric`, and before and after passes that change
/// it.
namespace camber::run {

/// The report, and what it counts, one a unique edge and one an element.
struct UnitMesh {
    UnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// Of lengths, one an edge, and qualities, one an element.
[[nodiscard]] UnitMeshReport unit_mesh_report(std::string metric, const std::vector<double>& lengths,
                                              const std::vector<double>& qualities);

/// `metric`: the name of what the logs, one a vertex, are.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Column<LogMetric<D>>& log_metrics, std::string metric,
                                                  const Execution& execution);

/// Of a mesh of degree 2: along its curves, and by the mean distortion of its elements.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                  std::string metric, const Execution& execution);

/// Its histograms, by one series of that name each.
[[nodiscard]] std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series);

/// Lines for a terminal; a JSON object.
[[nodiscard]] std::string unit_mesh_rows(const UnitMeshReport& report);
[[nodiscard]] std::string unit_mesh_json(const UnitMeshReport& report);

}  // namespace camber::run
