// Runs a pipeline over the blocks of a mesh, and reports results that miss a request
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
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.crossing;
import camber.fields;
import camber.surface;
import camber.cad;
import camber.curving;
import camber.repair;
import camber.recipes;
import camber.distributed;
import camber.config;
import :json;

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

namespace {

template <class T>
T most(const std::vector<T>& of_ranks) {
    return of_ranks.empty() ? T{} : *std::ranges::max_element(of_ranks);
}

nlohmann::ordered_json verdicts(const BlocksValidation& v) {
    return {{"invalid", v.invalid},
            {"undecided", v.undecided},
            {"not_certified", v.not_positive},
            {"min_scaled_jacobian", v.smallest}};
}

}  // namespace

template <int D>
WallsReport walls_report(const WallsOfBlocks<D>& walls) {
    const auto& found = walls.crossings.found;
    const auto pair = std::ranges::find(found, Crossing::crossing, &FacetCrossing::verdict);
    WallsReport report =
        walls_report<D>(walls.crossings, [&](FacetId f) { return walls.first_crossing[f == pair->first ? 0 : 1]; });
    report.crossing_before = walls.crossing_before;
    if (walls.moved.nodes > 0) report.relaxed = relaxed_walls_report(walls.moved);
    return report;
}
template WallsReport walls_report<2>(const WallsOfBlocks<2>&);
template WallsReport walls_report<3>(const WallsOfBlocks<3>&);

template <int D>
void add(ByBlocksReport& report, const DeviationOfBlocks<D>& deviation, const BoundaryTolerance& tolerance) {
    const auto& [nodes, vertices] = deviation.found;
    report.nodes =
        deviation_report(nodes, tolerance.nodes, {deviation.edge[0] + 1, deviation.edge[1] + 1}, deviation.node);
    report.boundary_vertices =
        deviation_report(vertices, tolerance.vertices, {deviation.vertex + 1, 0}, deviation.point);
}
template void add<2>(ByBlocksReport&, const DeviationOfBlocks<2>&, const BoundaryTolerance&);
template void add<3>(ByBlocksReport&, const DeviationOfBlocks<3>&, const BoundaryTolerance&);

std::string table(const ByBlocksReport& r) {
    const std::size_t in_all = r.before.invalid + r.before.undecided;
    std::string text = table_row("dimension, degree", fmt::format("{}, 2", r.dimension)) +
                       table_row("vertices", r.vertices) + table_row("elements", r.elements) +
                       table_row("edges", r.edges) +
                       table_row("blocks, of about so many elements",
                                 fmt::format("{}, {}", grouped(r.blocks), grouped(r.elements_of_block))) +
                       table_row("ranks", r.ranks) +
                       table_row("volume edges that are curved",
                                 fmt::format("{} of {}", grouped(r.curved_edges), grouped(r.volume_edges))) +
                       table_row("elements not valid before repair", in_all);
    if (in_all > 0)
        text += table_row("repaired elements", r.repair.corrected_elements) +
                table_row("elements not valid now", r.after.invalid + r.after.undecided);
    if (r.repair.raised_elements > 0) text += table_row("raised elements", r.repair.raised_elements);
    text += deviation_row("nodes off the geometry", r.nodes);
    text += deviation_row("vertices off the geometry", r.boundary_vertices);
    text += walls_rows(r.walls);
    text += table_row("smallest scaled Jacobian", fmt::format("{:.4g}", r.after.smallest));
    for (const StageTime& step : r.times) text += table_row(step.stage, fmt::format("{:.2f} s", step.seconds));
    text += table_row("peak memory of a rank", fmt::format("{} MB", grouped(most(r.peak_bytes) / 1000000)));
    if (r.ranks > 1)
        text +=
            table_row("sent by a rank, at most",
                      fmt::format("{:.1f} MB in {} rounds", static_cast<double>(most(r.sent_bytes)) / 1e6, r.rounds));
    return text;
}

std::string to_json(const ByBlocksReport& r) {
    Json boundary = json_of(r.walls);
    boundary["node_deviation"] = json_of(r.nodes);
    boundary["vertex_deviation"] = json_of(r.boundary_vertices);
    const Json j{{"format", report_format},
                 {"mesh",
                  {{"dimension", r.dimension},
                   {"degree", 2},
                   {"vertices", r.vertices},
                   {"elements", r.elements},
                   {"facets", r.facets},
                   {"edges", r.edges}}},
                 {"blocks", {{"number", r.blocks}, {"elements", r.elements_of_block}}},
                 {"curve",
                  {{"volume_edges", r.volume_edges},
                   {"curved_edges", r.curved_edges},
                   {"extension_iterations", r.extension_iterations}}},
                 {"boundary", std::move(boundary)},
                 {"bound", r.bound},
                 {"before_repair", verdicts(r.before)},
                 {"validity", verdicts(r.after)},
                 {"ranks",
                  {{"number", r.ranks},
                   {"rounds", r.rounds},
                   {"peak_bytes", r.peak_bytes},
                   {"cpu_seconds", r.processor_seconds},
                   {"sent_bytes", r.sent_bytes}}},
                 {"misses", misses(r)},
                 {"stages", json_of(r.times)}};
    return j.dump(2) + "\n";
}

namespace {

/// "3, 17, 18 and 240 more".
std::string listed(const std::vector<std::size_t>& elements) {
    constexpr std::size_t shown = 10;
    std::string text;
    for (std::size_t i = 0; i < std::min(shown, elements.size()); ++i)
        text += (i > 0 ? ", " : "") + std::to_string(elements[i]);
    if (elements.size() > shown) text += fmt::format(" and {} more", elements.size() - shown);
    return text;
}

/// Returns options that make the remaining elements valid, as far as they are known; else nothing.
std::string remedies_of_elements(const Report& r) {
    if (!r.input_boundary || r.remaining.empty()) return {};
    std::vector<std::string> ways;
    if (const auto& tolerance = r.input_boundary->sufficient_tolerance)
        ways.push_back(fmt::format("--boundary-tolerance {:g} (tried: every element is valid then)", *tolerance));
    if (r.validity && r.validity->straight_inverted > 0)
        ways.emplace_back("`camber remesh`, which replaces elements that are inverted when straight");
    else if (r.origin && (r.origin->geometry == "surrogate" || r.origin->geometry == "straight"))
        ways.emplace_back("--cad MODEL, or --geometry, on which the boundary's nodes may slide");
    return fmt::format("{}", fmt::join(ways, ", or "));
}

std::string elements_missed(const Report& r) {
    const std::size_t straight = r.validity->straight_inverted;
    const std::size_t below = r.validity->is_asked ? r.elements_below_bound.size() : 0;
    std::string line = fmt::format("{} elements are not certified valid", r.not_valid());
    if (below > 0) line += fmt::format(" above {:g}", r.validity->bound);
    if (!r.invalid_elements.empty()) line += "; invalid: " + listed(r.invalid_elements);
    if (!r.undecided_elements.empty()) line += "; undecided: " + listed(r.undecided_elements);
    if (below > 0) line += fmt::format("; below {:g}: ", r.validity->bound) + listed(r.elements_below_bound);
    if (const std::string help = remedies_of_elements(r); !help.empty()) line += "; what would help: " + help;
    if (straight > 0 && !r.remesh)  // what passes leave inverted when straight is no fault
        line += fmt::format(" ({} flat or inverted before it was curved: mend the straight mesh)", straight);
    return line;
}

/// "vertex 12 at (1, 0, 0.5)", "edge 12 to 40 near (1, 0, 0.5)".
std::string place_of(const DeviationReport& d) {
    const std::string entity = d.vertices[1] == 0 ? fmt::format("vertex {} at", d.vertices[0])
                                                  : fmt::format("edge {} to {} near", d.vertices[0], d.vertices[1]);
    return fmt::format("{} ({:.6g})", entity, fmt::join(d.at, ", "));
}

std::string deviation_missed(const DeviationReport& d, std::string_view entities) {
    return fmt::format(
        "{} of {} boundary {} {} off the geometry by more than {:g} of the local edge length (largest distance {:.4g}; "
        "worst: {}, by {:.3g} of it)",
        d.off, d.measured, entities, d.off == 1 ? "is" : "are", d.tolerance, d.largest, place_of(d), d.share);
}

/// Causes for which nodes of the boundary are off.
struct NodeCauses {
    std::size_t relaxed = 0;    ///< boundary edges whose nodes repair moved
    bool is_uncrossed = false;  ///< nodes were moved back until no boundary facets crossed
    std::size_t given_up = 0;   ///< elements on which the budget of work was spent
};

std::string nodes_missed(const DeviationReport& d, const NodeCauses& causes) {
    std::string line = deviation_missed(d, "nodes");
    if (causes.relaxed > 0) line += "; cause: validity, nodes were relaxed until elements are valid";
    if (causes.is_uncrossed) line += "; cause: crossing, nodes were moved back until no boundary facets cross";
    if (causes.given_up > 0)
        line +=
            fmt::format("; cause: budget of work, spent on {} elements (the option effort of relax)", causes.given_up);
    return line +
           fmt::format("; remedy: smaller elements there, or accept it by --geometry-tolerance {:.2g}", 1.1 * d.share);
}

NodeCauses causes_of(const Report& r) {
    NodeCauses causes;
    if (r.relax) causes.relaxed = r.relax->relaxed_surface_edges, causes.given_up = r.relax->given_up;
    if (const auto& walls = r.boundary->walls; walls && walls->relaxed) {
        causes.is_uncrossed = true;
        causes.relaxed -= std::min(causes.relaxed, walls->relaxed->nodes);  // counted among the relaxed ones too
    }
    return causes;
}

std::string vertices_missed(const DeviationReport& d, const char* remedy) {
    return deviation_missed(d, "vertices") + "; remedy: " + remedy;
}
constexpr const char* other_mesh = "a mesh of this geometry";
constexpr const char* move_vertices_first = "--cad-vertices move, or a mesh of this geometry";

/// True if the boundary has a prescribed geometry, on which its nodes may slide.
bool slides_on_geometry(const Report& r) {
    return r.origin && (r.origin->geometry == "cad" || r.origin->geometry == "analytic");
}

}  // namespace

std::vector<std::string> misses(const Report& report) {
    std::vector<std::string> all;
    if (!report.has_valid_elements()) all.push_back(elements_missed(report));
    if (std::string overlaps = overlap_message(report); !overlaps.empty()) all.push_back(std::move(overlaps));
    if (!report.boundary) return all;
    const BoundaryReport& boundary = *report.boundary;
    if (!report.keeps_geometry_error()) all.push_back(sentence_of(*boundary.geometry_error));
    const auto is_off = [](const std::optional<DeviationReport>& d) { return d && d->off > 0; };
    const int dimension = report.mesh.dimension;
    if (is_off(boundary.node_deviation)) all.push_back(nodes_missed(*boundary.node_deviation, causes_of(report)));
    if (is_off(boundary.vertex_deviation))
        all.push_back(vertices_missed(*boundary.vertex_deviation,
                                      boundary.cad && !boundary.cad->moves ? move_vertices_first : other_mesh));
    if (!report.walls_hold()) all.push_back(crossing_message(*boundary.walls, dimension));
    return all;
}

std::vector<std::string> misses(const ByBlocksReport& report) {
    std::vector<std::string> all;
    if (!report.has_valid_elements()) {
        all.push_back(fmt::format("{} elements are not certified valid", report.after.not_positive));
        if (report.is_asked)
            all.back() += fmt::format("; {} elements, these included, are not certified above {:g}",
                                      report.after.invalid + report.after.undecided, report.bound);
    }
    const NodeCauses causes{report.repair.moved_surface_nodes, report.walls.relaxed.has_value()};
    const int dimension = static_cast<int>(report.dimension);
    if (report.nodes.off > 0) all.push_back(nodes_missed(report.nodes, causes));
    if (report.boundary_vertices.off > 0) all.push_back(vertices_missed(report.boundary_vertices, other_mesh));
    if (std::string walls = crossing_message(report.walls, dimension); !walls.empty()) all.push_back(std::move(walls));
    return all;
}

std::string recommended_bound_note(const Report& r) {
    if (!r.validity || r.validity->is_asked || r.elements_below_bound.empty()) return {};
    std::string_view raise;
    if (r.input_boundary && slides_on_geometry(r))
        raise = "; --boundary-tolerance gives it room to raise them";
    else if (r.input_boundary)
        raise = "; --boundary-tolerance or --cad gives it room to raise them";
    else if (r.curve && r.curve->objective == "shape")
        raise = "; smaller elements there raise them";
    else if (r.curve)
        raise = "; --objective shape, or smaller elements there, raises them";
    return fmt::format(
        "{} {} valid, but below the recommended scaled Jacobian {:g}: {} (no failure: "
        "--min-scaled-jacobian {:g} would make it one{})",
        r.elements_below_bound.size(), r.elements_below_bound.size() == 1 ? "element is" : "elements are",
        r.validity->bound, listed(r.elements_below_bound), r.validity->bound, raise);
}

}  // namespace camber::run
