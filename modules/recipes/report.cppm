module;
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>
export module camber.recipes:report;
export import :boundary_report;
export import :step_reports;
import camber.core;
import camber.metric;
import camber.validity;
import camber.repair;
import camber.stages;
import camber.distributed;
import :fields;
import :measurements;

/// Report of a run: plain numbers, printed as a table and written as report.json.
export namespace camber::run {

/// Format number of report.json, check and geometry --json. It increases when a key is removed, renamed or redefined.
inline constexpr int report_format = 5;

struct OriginReport {
    std::string version;       ///< of the program
    std::string mesh, metric;  ///< file names; empty: generated mesh, no metric file
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::string config;    ///< the pipeline with every default, as JSON
    std::string geometry;  ///< "surrogate", "straight", "mesh", "analytic" or "cad"

    static void fields(auto& s, auto& f) {
        f("mesh", only_if(!s.mesh.empty(), s.mesh), "file of the input mesh; null: the mesh was generated", or_null);
        f("metric", only_if(!s.metric.empty(), s.metric), "file of the metric; null: none", or_null);
        f("dimension", s.dimension, "dimension of the input mesh: 2 or 3");
        f("degree", s.degree, "degree of the input mesh: 1 straight, 2 curved");
        f("vertices", s.vertices, "number of vertices of the input mesh, before `prepare`");
        f("elements", s.elements, "number of elements of the input mesh, before `prepare`");
        f("facets", s.facets, "number of facets of the input mesh, before `prepare`");
    }
};

struct ReorderedReport {
    double scatter = 0;

    static void fields(auto& s, auto& f) {
        f("scatter", s.scatter,
          "scatter of the input's order in memory. Output and report have the order of the input "
          "([space-filling-order.md](algorithms/space-filling-order.md))",
          unit("1"));
    }
};

struct StageTime {
    std::string stage;
    double seconds = 0;
    std::size_t peak_bytes = 0;

    static void fields(auto& s, auto& f) {
        f("stage", s.stage, "name of the step; all steps are listed in order, including reading and writing");
        f("seconds", s.seconds, "elapsed time", unit("s"));
        f("peak_bytes", s.peak_bytes, "peak memory of the process until the end of this step", unit("bytes"));
    }
};

struct BlocksReport {
    std::size_t number = 0, elements = 0, extension_iterations = 0;

    static void fields(auto& s, auto& f) {
        f("number", s.number, "number of blocks");
        f("elements", s.elements, "requested number of elements in a block");
        f("extension_iterations", s.extension_iterations,
          "number of iterations that extended the displacement of the boundary");
    }
};

/// Lists have one entry per rank.
struct RanksReport {
    std::size_t number = 1, rounds = 0;
    std::vector<std::size_t> peak_bytes;
    std::vector<double> processor_seconds;
    std::vector<std::size_t> sent_bytes;

    static void fields(auto& s, auto& f) {
        f("number", s.number, "number of ranks");
        f("rounds", s.rounds, "number of exchanges between ranks");
        f("peak_bytes", s.peak_bytes, "peak memory of each rank", unit("bytes"));
        f("cpu_seconds", s.processor_seconds, "CPU time of each rank", unit("s"));
        f("sent_bytes", s.sent_bytes, "data that each rank sent", unit("bytes"));
    }
};

struct Report {
    std::optional<OriginReport> origin;
    std::optional<ReorderedReport> reordered;
    MeshReport mesh;
    std::optional<SolutionMetricReport> solution_metric;
    std::optional<MetricReport> metric;
    std::optional<RemeshReport> remesh;
    std::optional<BoundaryReport> boundary;
    std::optional<CurveReport> curve;
    std::optional<ValidityReport> validity_before, validity;
    std::optional<RelaxReport> relax;
    std::optional<InputBoundaryReport> input_boundary;
    std::vector<RemainingReport> remaining;
    std::optional<ReinsertReport> reinsert;
    std::optional<TransferReport> transfer;
    std::optional<BlocksReport> blocks;
    std::optional<RanksReport> ranks;
    OverlappingReport overlaps;
    bool committed = false;
    /// Elements of the final mesh that are not certified valid, from 1 (complete lists).
    std::vector<std::size_t> invalid_elements, undecided_elements, elements_below_bound;
    std::vector<Histogram> histograms;
    std::vector<std::string> notices;
    std::vector<StageTime> times;
    int threads = 0;

    static void fields(auto& s, auto& f) {
        f("reordered", s.reordered, "order of the mesh, if stages worked in another one");
        f("mesh", s.mesh, "the final mesh");
        f("solution_metric", s.solution_metric, "the metric made for the solution");
        f("metric", s.metric, "the metric");
        f("remesh", s.remesh, "passes that changed the mesh");
        f("boundary", s.boundary, "the boundary and its geometry");
        f("curve", s.curve, "the stage `curve`");
        f("validity_before_correction", s.validity_before, "verdicts of the elements that `curve` proposed");
        f("relax", s.relax, "the stage `relax`");
        f("input_boundary", s.input_boundary, "boundary of a mesh that was read with its curves");
        f("remaining_elements", only_if(s.input_boundary || !s.remaining.empty(), s.remaining),
          "elements that could not be repaired");
        f("reinsert", s.reinsert, "the stage `reinsert`");
        f("validity", s.validity, "verdicts of the final elements");
        f("overlaps", only_if(s.overlaps.overlapping > 0, s.overlaps), "elements of the result that overlap");
        f("transfer", s.transfer, "fields of the solution on the new mesh ([transfer.md](algorithms/transfer.md))");
        f("blocks", s.blocks, "blocks of a mesh that was curved by blocks");
        f("ranks", s.ranks, "costs of each rank");
        f("histograms", s.histograms, "see below", unless_empty);
        f("invalid_elements", s.invalid_elements, "elements of the final mesh that are not valid, from 1");
        f("undecided_elements", s.undecided_elements, "elements without a certified answer, from 1");
        f("elements_below_bound", s.elements_below_bound, "valid elements below the bound, from 1");
        f("committed", s.committed, "true: `commit` applied the proposed positions to the mesh");
        f("notices", s.notices, "notes on corrections, omissions and losses, one sentence each");
        f("misses", misses(s),
          "reasons why the result is not the requested one, one sentence with a place each; empty: the exit code is 0");
        f("threads", s.threads, "number of threads that were used");
        f("stages", s.times, "steps and their times");
    }

    [[nodiscard]] bool has_valid_elements() const { return not_valid() == 0; }
    /// Number of elements that are not certified valid, or not above a required bound.
    [[nodiscard]] std::size_t not_valid() const {
        if (!validity) return 0;
        return validity->invalid + validity->undecided + (validity->is_explicit ? validity->below_bound : 0);
    }
    [[nodiscard]] bool is_boundary_within_bounds() const {
        const auto holds = [](const std::optional<DeviationReport>& d) { return !d || d->off == 0; };
        return !boundary || (holds(boundary->node_deviation) && holds(boundary->vertex_deviation));
    }
    [[nodiscard]] bool are_facets_disjoint() const {
        return !boundary || !boundary->walls || boundary->walls->crossing == 0;
    }
    [[nodiscard]] bool meets_geometry_error() const {
        return !boundary || !boundary->geometry_error || !boundary->geometry_error->is_required ||
               boundary->geometry_error->is_met();
    }
    /// True if the exit code is 0.
    [[nodiscard]] bool meets_requirements() const {
        return has_valid_elements() && is_boundary_within_bounds() && meets_geometry_error() && are_facets_disjoint() &&
               overlaps.overlapping == 0;
    }
};

/// Groups digits by threes: "1 234 567".
[[nodiscard]] std::string grouped(std::size_t n);
/// Four digits: "(0.5, 1.25)".
[[nodiscard]] std::string place_text(const ReportedPlace& place);
/// Bounds in four digits: lower ones are rounded down, upper ones up.
[[nodiscard]] std::string lower_bound_text(double x);
[[nodiscard]] std::string upper_bound_text(double x);

/// One sentence, with a place, for each reason why the result is not the requested one; empty: it is.
[[nodiscard]] std::vector<std::string> misses(const Report& report);

/// Note on valid elements below the recommended bound; empty: none, or the bound is required.
[[nodiscard]] std::string recommended_bound_note(const Report& report);
/// "16 pairs of boundary triangles pass through each other …"; empty: no crossing.
[[nodiscard]] std::string crossing_message(const WallsReport& walls, int dimension);
/// "elements overlap in 3 places …"; empty: no overlap.
[[nodiscard]] std::string overlap_message(const Report& report);

using Notices = std::vector<std::string>;

struct VerdictsReport {
    ValidityReport summary;
    std::vector<std::size_t> invalid, undecided, below_bound;  ///< elements, from 1
};
/// `is_explicit`: the bound is required.
template <int D>
[[nodiscard]] VerdictsReport verdicts_report(const Validation<D>& validation, bool is_explicit);

/// `unresolved`: number of elements left when the limit of work is reached.
[[nodiscard]] RelaxReport relax_report(const RepairStatistics& statistics, std::size_t unresolved, RepairMethod method);

template <int D>
[[nodiscard]] RelaxedWallsReport relaxed_walls_report(const MoveBackStatistics<D>& moved) {
    return {moved.nodes, moved.largest, {moved.largest_at.c.begin(), moved.largest_at.c.end()}};
}

struct CorrectionReport {
    RelaxReport relax;
    std::optional<InputBoundaryReport> input_boundary;
    std::vector<RemainingReport> remaining;
};

void add(Report& report, const BoundaryReport& part);
void add(Report& report, VerdictsReport part);
/// Sums counts of several corrections.
void add(Report& report, const CorrectionReport& part);
/// Sums counts of passes of one kind.
void add(Report& report, const PassReport& part);
void add(std::vector<Histogram>& all, std::vector<Histogram> part);

template <class R>
struct MeasuredInMetric {
    R report;
    std::vector<double> lengths, qualities;
};
using UnitMesh = MeasuredInMetric<UnitMeshReport>;

[[nodiscard]] UnitMeshReport unit_mesh_report(std::string metric, const std::vector<double>& lengths,
                                              const std::vector<double>& qualities);

/// `metric`: name of the metric; `log_metrics`: one per vertex.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Column<LogMetric<D>>& log_metrics, std::string metric,
                                                  const Execution& execution);

/// The same for degree 2: lengths along curves, and mean distortion of elements.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                  std::string metric, const Execution& execution);

[[nodiscard]] std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series);

struct CurvedUnitMeshReport {
    struct Element {
        std::size_t number = 0;
        double quality = 0, least = 0, bound = 0;

        static void fields(auto& s, auto& f) {
            f("element", s.number, "element, from 1");
            f("quality", s.quality, "its quality by the mean distortion", unit("1"));
            f("least", s.least, "lowest quality found at a point", unit("1"));
            f("bound", s.bound, "certified lower bound of its quality at all points", unit("1"));
        }
    };
    UnitMeshReport unit_mesh;
    Element lowest;  ///< element with the lowest quality at a point; number 0: none
    double bound = 0;
    std::vector<Element> worst;

    static void fields(auto& s, auto& f) {
        f.merged(s.unit_mesh);
        f("bound", only_if(s.lowest.number > 0, s.bound),
          "certified lower bound of the quality (with the sign of det J) at all points of the mesh; −1: no bound above "
          "0 was found",
          unit("1"));
        f("lowest", only_if(s.lowest.number > 0, s.lowest), "element with the lowest quality at a point");
        f("worst", s.worst, "elements with the lowest mean qualities, the worst first, at most `worst`");
    }
};

using CurvedUnitMesh = MeasuredInMetric<CurvedUnitMeshReport>;

/// `metric`: name of the metric; `log_metrics`: one per vertex; `worst`: number of elements to list.
template <int D>
[[nodiscard]] Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh,
                                                               const Column<LogMetric<D>>& log_metrics,
                                                               std::string metric, std::size_t worst,
                                                               const Execution& execution);

[[nodiscard]] std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series);

/// Equal to the values of the whole mesh up to the last digits of means.
struct UnitMeshOfRanks {
    UnitMeshReport report;
    std::vector<Histogram> histograms;
};
/// Errors: those of any rank.
[[nodiscard]] Outcome<UnitMeshOfRanks> unit_mesh_of_ranks(std::string metric, const MeasuredRows& own, Ranks& ranks);

}  // namespace camber::run
