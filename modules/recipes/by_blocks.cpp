module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.fields;
import camber.surface;
import camber.cad;
import camber.curving;
import camber.repair;
import camber.stages;
import camber.distributed;

namespace camber::run {

namespace {

auto not_by_blocks(const std::string& what, const std::string& where) {
    return fail(ErrorKind::unsupported, what + " is not supported when curving by blocks", where, {},
                "remove it, or curve the whole mesh, on one rank and without blocks");
}

/// Checks that a metric can be computed at each vertex separately.
Outcome<Done> check_metric(const config::Metric& metric, const std::string& where) {
    const bool is_local = std::visit(
        []<class M>(const M&) {
            return std::is_same_v<M, config::FilePath> || std::is_same_v<M, config::ConstantMetric> ||
                   std::is_same_v<M, config::FieldMetric> || std::is_same_v<M, MetricExpression>;
        },
        metric);
    if (is_local) return Done{};
    return not_by_blocks("a metric that depends on the whole mesh", where);
}

Outcome<Done> check_metrics(const config::Pipeline& pipeline) {
    if (std::holds_alternative<config::NaturalMetric>(pipeline.metric)) {
        if (pipeline.metric_operations.empty()) return Done{};
        return not_by_blocks("an operation on the mesh-implied metric", "/metric_operations");
    }
    if (auto known = check_metric(pipeline.metric, "/metric"); !known) return known;
    for (std::size_t i = 0; i < pipeline.metric_operations.size(); ++i) {
        const std::string where = "/metric_operations/" + std::to_string(i);
        const config::MetricOperation& operation = pipeline.metric_operations[i];
        if (std::holds_alternative<config::Bound>(operation)) continue;
        const auto* const intersect = std::get_if<config::Intersect>(&operation);
        if (intersect == nullptr) return not_by_blocks("gradation, or a metric of a prescribed complexity,", where);
        if (auto known = check_metric(intersect->metric, where); !known) return known;
    }
    return Done{};
}

MetricFile rows_of(const MetricFile& file, std::span<const GlobalNumber> vertices) {
    MetricFile out{file.name, file.solution, {}, file.metric_config};
    const std::size_t width = file.solution.rows == 0 ? 0 : file.solution.values.size() / file.solution.rows;
    Buffer<double> values;
    values.reserve(vertices.size() * width);
    for (const GlobalNumber v : vertices)
        for (std::size_t k = 0; k < width && v < file.solution.rows; ++k)
            values.push_back(file.solution.values[v * width + k]);
    out.solution.values = std::move(values);
    out.solution.rows = vertices.size();
    return out;
}

template <int D>
Outcome<Column<LogMetric<D>>> metric_of_block(const config::Pipeline& pipeline, std::span<const MetricFile> files,
                                              const LinearMesh<D>& block, std::span<const GlobalNumber> vertices,
                                              const Execution& execution) {
    std::vector<MetricFile> rows;
    for (const MetricFile& file : files) rows.push_back(rows_of(file, vertices));
    const Boundary<D> none{{}, RequiredBoundary::keep, Geometry<D>(StraightGeometry<D>{})};
    const MetricInput<D> input{block, {}, none, block.points, rows, {}, nullptr};
    auto result = make_log_metrics(input, pipeline.metric, execution);
    if (!result) return fail(result.error());
    result = apply_operations(std::move(*result), input, pipeline.metric_operations, execution);
    if (!result) return fail(result.error());
    return std::move(result->log_metrics);
}

Outcome<Done> check_sources(const config::Pipeline& pipeline) {
    if (auto known = check_metrics(pipeline); !known) return known;
    if (const auto* cad = std::get_if<config::Cad>(&pipeline.geometry); cad && cad->vertices != CadVertices::keep)
        return not_by_blocks("moving vertices onto the CAD model", "/geometry/cad/vertices");
    if (!pipeline.solution.file.empty() || !pipeline.solution.expression.empty())
        return not_by_blocks("transfer of fields", "/solution");
    return Done{};
}

/// Functions for geometry and metric of blocks. They refer to the arguments, and add notices of this rank to `report`.
template <int D>
BlocksGoal<D> goal_of(const config::Pipeline& pipeline, const BlockSources& sources, Report& report) {
    BlocksGoal<D> goal;
    goal.boundary = [&](const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                        const Execution& e) -> Outcome<Boundary<D>> {
        const auto source = in_unit_of_mesh(pipeline.geometry, sources.geometry, mesh, without_progress(e));
        if (!source) return fail(source.error());
        auto result = boundary_by_config(pipeline, *source, mesh, edges, e);
        if (!result) return fail(result.error());
        add(report, result->report);
        return std::move(result->boundary);
    };
    if (!std::holds_alternative<config::NaturalMetric>(pipeline.metric))
        goal.metric = [&pipeline, &sources](const LinearMesh<D>& block, std::span<const GlobalNumber> vertices,
                                            const Execution& e) {
            return metric_of_block<D>(pipeline, sources.files, block, vertices, e);
        };
    return goal;
}

template <int D>
WallsReport report_of(const WallsOfBlocks<D>& walls) {
    const auto& found = walls.crossings.found;
    const auto pair = std::ranges::find(found, Crossing::crossing, &FacetCrossing::verdict);
    WallsReport report =
        walls_report<D>(walls.crossings, [&](FacetId f) { return walls.first_crossing[f == pair->first ? 0 : 1]; });
    report.crossing_before = walls.crossing_before;
    if (walls.moved.nodes > 0) report.relaxed = relaxed_walls_report(walls.moved);
    return report;
}

ValidityReport validity_report(const BlocksValidation& v, const JacobianBound& bound, std::size_t elements) {
    return {.bound = bound.value,
            .is_explicit = bound.is_explicit,
            .invalid = v.invalid,
            .undecided = v.undecided,
            .below_bound = v.below_bound,
            .smallest = v.smallest,
            .worst = elements > 0 ? v.worst + 1 : 0};
}

template <int D>
class BlockRunner {
  public:
    BlockRunner(const MeshRows<D>& rows, const config::Pipeline& pipeline, const BlockSources& sources,
                const StepWrapper& around)
        : pipeline_(pipeline),
          sources_(sources),
          around_(around),
          goal_(goal_of<D>(pipeline, sources, report_)),
          steps_(rows, goal_, sources.blocks, *sources.ranks) {}
    BlockRunner(const BlockRunner&) = delete;
    BlockRunner(BlockRunner&&) = delete;
    BlockRunner& operator=(const BlockRunner&) = delete;
    BlockRunner& operator=(BlockRunner&&) = delete;
    ~BlockRunner() = default;

    Outcome<BlocksRun<D>> run() {
        if (auto supported = check_sources(pipeline_); !supported) return fail(supported.error());
        if (auto order = check_order(pipeline_.stages, 1); !order) return fail(order.error());
        for (at_ = 0; at_ < pipeline_.stages.size(); ++at_) {
            auto done = std::visit([&](const auto& stage) { return apply(stage); }, pipeline_.stages[at_]);
            if (!done) return fail(done.error());
        }
        if (auto done = steps_.measure(pipeline_.geometry_tolerance, around_); !done) return fail(done.error());
        auto curved = std::move(steps_).finish();
        if (!curved) return fail(curved.error());
        add_to_report(*curved);
        return BlocksRun<D>{std::move(*curved), std::move(report_)};
    }

  private:
    Outcome<Done> apply(const config::Elevate&) { return steps_.elevate(around_); }
    Outcome<Done> apply(const config::Curve& options) { return steps_.curve(options, around_); }
    Outcome<Done> apply(const config::Validate& options) {
        RepairOptions repair = following_repair();
        if (options.min_scaled_jacobian.is_explicit || !repair.min_scaled_jacobian.is_explicit)
            bound_ = repair.min_scaled_jacobian = options.min_scaled_jacobian;
        return steps_.validate(repair, around_);
    }
    Outcome<Done> apply(const config::Relax& options) {
        RepairOptions repair = options;
        if (options.min_scaled_jacobian.is_explicit) bound_ = options.min_scaled_jacobian;
        repair.min_scaled_jacobian = bound_;
        method_ = options.method;
        return steps_.relax(repair, around_);
    }
    Outcome<Done> apply(const config::Commit&) {
        report_.committed = true;
        return Done{};
    }
    template <class Options>
    Outcome<Done> apply(const Options&) {
        return not_by_blocks("the stage " + std::string(std::get<Step<Options>>(step_table).name),
                             "/stages/" + std::to_string(at_));
    }

    /// One pass then computes verdicts and lists elements to repair.
    [[nodiscard]] RepairOptions following_repair() const {
        for (std::size_t i = at_; i < pipeline_.stages.size(); ++i)
            if (const auto* relax = std::get_if<config::Relax>(&pipeline_.stages[i])) return *relax;
        return {};
    }

    void add_to_report(const CurvedBlocks<D>& curved) {
        const RowCounts& n = curved.counts;
        const std::size_t edges = curved.first_edges.back();
        report_.mesh = {D, 2, n.points, n.points + edges, n.elements, n.facets, n.edges};
        report_.curve = CurveReport{curved.statistics, edges};
        report_.blocks = BlocksReport{curved.parts.layout.blocks(), sources_.blocks.elements, curved.iterations};
        report_.validity_before = validity_report(curved.before, bound_, n.elements);
        report_.validity = validity_report(curved.after, bound_, n.elements);
        report_.relax = relax_report(curved.repair, 0, method_);
        if (!report_.boundary) report_.boundary.emplace();
        report_.boundary->walls = report_of(curved.walls);
        const BoundaryTolerance& tolerance = pipeline_.geometry_tolerance;
        const auto& [found, edge, node, vertex, point] = curved.deviation;
        report_.boundary->node_deviation =
            deviation_report(found.nodes, tolerance.nodes, {edge[0] + 1, edge[1] + 1}, node);
        report_.boundary->vertex_deviation =
            deviation_report(found.vertices, tolerance.vertices, {vertex + 1, 0}, point);
    }

    const config::Pipeline& pipeline_;
    const BlockSources& sources_;
    const StepWrapper& around_;
    Report report_;
    BlocksGoal<D> goal_;
    BlockSteps<D> steps_;
    std::size_t at_ = 0;
    JacobianBound bound_ = {};
    RepairMethod method_ = {};
};

}  // namespace

std::optional<CurveByBlocks> requested_blocks(const config::Pipeline& pipeline) {
    for (const config::Stage& stage : pipeline.stages)
        if (const auto* curve = std::get_if<config::Curve>(&stage))
            return curve->blocks > 0 || curve->memory > 0 ? std::optional<CurveByBlocks>(*curve) : std::nullopt;
    return std::nullopt;
}

template <int D>
Outcome<BlocksRun<D>> run_steps(const MeshRows<D>& rows, const config::Pipeline& pipeline, const BlockSources& sources,
                                const StepWrapper& around) {
    return together(*sources.ranks,
                    [&] { return guarded([&] { return BlockRunner<D>(rows, pipeline, sources, around).run(); }); });
}

template Outcome<BlocksRun<2>> run_steps<2>(const MeshRows<2>&, const config::Pipeline&, const BlockSources&,
                                            const StepWrapper&);
template Outcome<BlocksRun<3>> run_steps<3>(const MeshRows<3>&, const config::Pipeline&, const BlockSources&,
                                            const StepWrapper&);

}  // namespace camber::run
