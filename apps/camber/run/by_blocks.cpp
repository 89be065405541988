module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.curving;
import camber.distributed;
import camber.fields;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import :by_blocks;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

const config::Curve* curve_of(const config::Pipeline& pipeline) {
    for (const config::Stage& stage : pipeline.stages)
        if (const auto* curve = std::get_if<config::Curve>(&stage)) return curve;
    return nullptr;
}

auto not_by_blocks(const std::string& what, const std::string& where) {
    return fail(ErrorKind::unsupported, what + " is not supported when curving by blocks", where, {},
                "leave it out, or curve the mesh as a whole, on one rank and without blocks");
}

/// Metrics that are known at a vertex by itself.
Outcome<Done> check_metric(const config::Metric& metric, const std::string& where) {
    const bool is_local = std::visit(
        []<class M>(const M&) {
            return std::is_same_v<M, config::FilePath> || std::is_same_v<M, config::ConstantMetric> ||
                   std::is_same_v<M, config::FieldMetric> || std::is_same_v<M, MetricExpression>;
        },
        metric);
    if (is_local) return Done{};
    return not_by_blocks("a metric that is made of the whole mesh", where);
}

Outcome<Done> check_metrics(const config::Pipeline& pipeline) {
    if (std::holds_alternative<config::NaturalMetric>(pipeline.metric)) {
        if (pipeline.metric_operations.empty()) return Done{};
        return not_by_blocks("an operation on the mesh's own metric", "/metric_operations");
    }
    if (auto known = check_metric(pipeline.metric, "/metric"); !known) return known;
    for (std::size_t i = 0; i < pipeline.metric_operations.size(); ++i) {
        const std::string where = "/metric_operations/" + std::to_string(i);
        const config::MetricOperation& operation = pipeline.metric_operations[i];
        if (std::holds_alternative<config::Bound>(operation)) continue;
        const auto* const intersect = std::get_if<config::Intersect>(&operation);
        if (intersect == nullptr) return not_by_blocks("gradation, or a metric of a given complexity,", where);
        if (auto known = check_metric(intersect->metric, where); !known) return known;
    }
    return Done{};
}

/// The rows of a file at a block's vertices.
MetricFile rows_of(const MetricFile& file, std::span<const GlobalNumber> vertices) {
    MetricFile out{file.name, file.solution, {}, file.made_by};
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
    auto made = make_log_metrics(input, pipeline.metric, execution);
    if (!made) return fail(made.error());
    made = apply_operations(std::move(*made), input, pipeline.metric_operations, execution);
    if (!made) return fail(made.error());
    return std::move(made->log_metrics);
}

}  // namespace

bool asks_for_blocks(const config::Pipeline& pipeline) {
    const config::Curve* const curve = curve_of(pipeline);
    return curve != nullptr && (curve->blocks > 0 || curve->memory > 0);
}

double memory_by_blocks(const config::Pipeline& pipeline) {
    const config::Curve* const curve = curve_of(pipeline);
    return curve == nullptr ? 0 : curve->memory;
}

Outcome<CurveBlocksOptions> options_by_blocks(const config::Pipeline& pipeline) {
    const auto& stages = pipeline.stages;
    const bool is_curving =
        stages.size() == 5 && std::holds_alternative<config::Elevate>(stages[0]) &&
        std::holds_alternative<config::Curve>(stages[1]) && std::holds_alternative<config::Validate>(stages[2]) &&
        std::holds_alternative<config::Relax>(stages[3]) && std::holds_alternative<config::Commit>(stages[4]);
    if (!is_curving)
        return not_by_blocks("a list of stages other than elevate, curve, validate, relax, commit", "/stages");
    if (auto known = check_metrics(pipeline); !known) return fail(known.error());
    if (const auto* cad = std::get_if<config::Cad>(&pipeline.geometry); cad && cad->vertices != CadVertices::keep)
        return not_by_blocks("moving vertices onto the CAD model", "/geometry/cad/vertices");
    if (!pipeline.solution.file.empty() || !pipeline.solution.expression.empty())
        return not_by_blocks("transfer of fields", "/solution");
    const auto& curve = std::get<config::Curve>(stages[1]);
    CurveBlocksOptions options;
    if (curve.blocks > 0) options.blocks.elements = static_cast<std::size_t>(curve.blocks);
    options.curving.curve = static_cast<const ProposeOptions&>(curve);
    options.curving.repair = std::get<config::Relax>(stages[3]);
    options.tolerance = pipeline.geometry_tolerance;
    if (!options.curving.repair.min_scaled_jacobian.is_asked)
        options.curving.repair.min_scaled_jacobian = std::get<config::Validate>(stages[2]).min_scaled_jacobian;
    return options;
}

template <int D>
BlocksGoal<D> goal_by_blocks(const config::Pipeline& pipeline, const GeometrySource& geometry,
                             std::span<const MetricFile> files, Notices& notices) {
    BlocksGoal<D> goal;
    goal.boundary = [&](const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                        const Execution& e) -> Outcome<Boundary<D>> {
        const auto source = in_unit_of_mesh(pipeline.geometry, geometry, mesh, without_progress(e));
        if (!source) return fail(source.error());
        auto made = boundary_by_config(pipeline, *source, mesh, edges, e);
        if (!made) return fail(made.error());
        if (made->report.off_surfaces && made->report.off_surfaces->vertices > 0)
            notices.push_back(std::to_string(made->report.off_surfaces->vertices) +
                              " vertices of the boundary are off its surfaces; they stay where they are");
        return std::move(made->boundary);
    };
    if (!std::holds_alternative<config::NaturalMetric>(pipeline.metric))
        goal.metric = [&pipeline, files](const LinearMesh<D>& block, std::span<const GlobalNumber> vertices,
                                         const Execution& e) {
            return metric_of_block<D>(pipeline, files, block, vertices, e);
        };
    return goal;
}

template BlocksGoal<2> goal_by_blocks<2>(const config::Pipeline&, const GeometrySource&, std::span<const MetricFile>,
                                         Notices&);
template BlocksGoal<3> goal_by_blocks<3>(const config::Pipeline&, const GeometrySource&, std::span<const MetricFile>,
                                         Notices&);

}  // namespace camber::run
