module;
#include <cstddef>
#include <string>
#include <vector>
module camber.run:curved_unit_mesh;
import camber.core;
import camber.metric;
import :histogram;
import :report;

/// How near to unit a mesh of degree 2 is in a metric, along its curves: `camber check --metric`.
namespace camber::run {

struct CurvedUnitMeshReport {
    /// An element's quality, from 1: its mean, the least that was attained at a point, and what it is above everywhere.
    struct Element {
        std::size_t number = 0;
        double quality = 0, least = 0, bound = 0;
    };
    UnitMeshReport unit_mesh;    ///< lengths along the curves, mean qualities
    Element lowest;              ///< of the lowest quality at a point; its number 0: no element
    double bound = 0;            ///< above which the quality is at every point of the mesh
    std::vector<Element> worst;  ///< of the lowest mean qualities, the worst first
};

/// The report, and what it counts, one a unique edge and one an element.
struct CurvedUnitMesh {
    CurvedUnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// `metric`: the name of what the logs, one a vertex, are; `worst`: how many elements to name.
template <int D>
[[nodiscard]] Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh,
                                                               const Column<LogMetric<D>>& log_metrics,
                                                               std::string metric, std::size_t worst,
                                                               const Execution& execution);

[[nodiscard]] std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series);

/// Lines for a terminal; a JSON object.
[[nodiscard]] std::string curved_unit_mesh_rows(const CurvedUnitMeshReport& report);
[[nodiscard]] std::string curved_unit_mesh_json(const CurvedUnitMeshReport& report);

}  // namespace camber::run
