module;
#include <cstddef>
#include <optional>
#include <string>
#include <vector>
module camber.run:parts;
import camber.repair;
import camber.validity;
import :distances_report;
import :histogram;
import :report;

/// What each stage tells, and how it becomes part of the report.
namespace camber::run {

using Notices = std::vector<std::string>;

/// Of all elements, at the bound asked for.
struct VerdictsReport {
    ValidityReport summary;
    std::vector<std::size_t> invalid, undecided, below_bound;  ///< elements, from 1
};
/// `is_asked`: whether somebody did for the bound.
template <int D>
[[nodiscard]] VerdictsReport verdicts_report(const Validation<D>& validation, bool is_asked);

/// Of the same, before anything was corrected.
struct BeforeReport {
    ValidityReport summary;
};

/// What a repair came to; `given_up`: elements on which the work was spent in vain.
[[nodiscard]] RelaxReport relax_report(const RepairStatistics& statistics, std::size_t given_up, RepairMethod method);

/// Reports nodes that were moved back because walls crossed.
template <int D>
[[nodiscard]] RelaxedWallsReport relaxed_walls_report(const MovedBack<D>& moved) {
    return {moved.nodes, moved.largest, {moved.largest_at.c.begin(), moved.largest_at.c.end()}};
}

/// Of a correction.
struct CorrectionReport {
    RelaxReport relax;
    std::optional<KeptBoundaryReport> kept_boundary;
    std::vector<RemainingReport> remaining;
};

/// Of the stage that goes from vertex to vertex, but for its targets.
struct CavitiesReport {
    ValidityReport wanted;  ///< of the targets, before the cavities corrected them
    RelaxReport relax;
    ReinsertReport reinsert;
};

/// Planned places became the mesh's.
struct CommitReport {};

/// Of a plan at a run's end: whether its places are the mesh's.
struct PlanReport {
    bool is_mesh = false;
};

/// A mesh that passes are to change, and what they left.
struct BeginsChangingReport {
    UnitMeshReport unit_mesh;
};
struct FinishedNodesReport {
    RemeshedNodesReport nodes;
};
struct FinishedReport {
    UnitMeshReport unit_mesh;
    std::vector<Histogram> histograms;
};

/// Of a run's end.
struct MeasuresReport {
    std::optional<EdgeReport> edges;  ///< after correction
    std::optional<EdgeReport>
        edges_in_straight_field;  ///< the same in the straight field, where the back mesh is curved
    std::optional<double> straight_distance, curved_distance;  ///< see BoundaryReport
    std::optional<WallsReport> walls = {};
    std::optional<DeviationReport> node_deviation = {}, vertex_deviation = {};
    std::optional<DistancesReport> distances = {};
    std::optional<GeometryErrorReport> geometry_error = {};
    bool is_remeshed = false;  ///< what the report has of the boundary's vertices is of the mesh before
    std::vector<Histogram> histograms;
};

void add(Report& report, const Notices& notices);
void add(Report& report, const OverlappingReport& part);
void add(Report& report, const MetricReport& part);
void add(Report& report, const BoundaryReport& part);
void add(Report& report, const BoundaryNodesReport& part);
void add(Report& report, const CurveReport& part);
void add(Report& report, const VerdictsReport& part);
void add(Report& report, const BeforeReport& part);
/// Corrections add up: of the cavities' own, and of a stage `relax` after them.
void add(Report& report, const CorrectionReport& part);
void add(Report& report, const CavitiesReport& part);
void add(Report& report, const CommitReport&);
void add(Report& report, const PlanReport& part);
void add(Report& report, const MeshReport& part);
void add(Report& report, const BeginsChangingReport& part);
/// Passes of one kind add up.
void add(Report& report, const PassReport& part);
void add(Report& report, const FinishedReport& part);
void add(Report& report, const FinishedNodesReport& part);
void add(Report& report, const MeasuresReport& part);

}  // namespace camber::run
