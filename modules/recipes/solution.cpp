module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.recovery;
import camber.metric;
import camber.transfer;
import camber.solution_metric;
import camber.io;
import camber.fields;
import camber.stages;

namespace camber::run {

std::vector<Column<double>> scalars_of(std::span<const NamedField> fields) {
    std::vector<Column<double>> scalars;
    for (const NamedField& field : fields) {
        const auto width = static_cast<std::size_t>(field.field.components);
        for (std::size_t c = 0; c < width; ++c) {
            if (width == 1) {
                scalars.push_back(field.field.values);
                continue;
            }
            Buffer<double> values(field.field.values.size() / width, 0.0);
            for (std::size_t n = 0; n < values.size(); ++n) values[n] = field.field.values[n * width + c];
            scalars.emplace_back(std::move(values));
        }
    }
    return scalars;
}

Outcome<std::vector<NamedField>> named(std::vector<NamedField> fields, const std::vector<std::string>& names,
                                       const std::string& where) {
    if (names.empty()) return fields;
    std::vector<NamedField> selected;
    for (const std::string& name : names) {
        const auto found = std::ranges::find(fields, name, &NamedField::name);
        if (found == fields.end()) {
            std::string there;
            for (const NamedField& field : fields) there += (there.empty() ? "" : ", ") + field.name;
            return fail(ErrorKind::usage, "no field has the name " + name, where, {}, "the fields are " + there);
        }
        if (std::ranges::find(selected, name, &NamedField::name) == selected.end()) selected.push_back(*found);
    }
    return selected;
}

template <int D>
Outcome<QuadraticMesh<D>> of_degree_2(const AnyMesh& mesh, const Execution& execution) {
    const auto* const specified = std::get_if<Mesh<D>>(&mesh);
    if (!specified) return fail(ErrorKind::internal, "the mesh is of another dimension");
    if (specified->degree == 1)
        return as_linear(*specified).and_then([&](const auto& m) { return elevate(m, execution); });
    return as_quadratic(*specified);
}
template Outcome<QuadraticMesh<2>> of_degree_2<2>(const AnyMesh&, const Execution&);
template Outcome<QuadraticMesh<3>> of_degree_2<3>(const AnyMesh&, const Execution&);

Outcome<std::size_t> nodes_in_degree_2(const AnyMesh& mesh, const Execution& execution) {
    return std::visit(
        [&](const auto& m) -> Outcome<std::size_t> {
            if (m.degree == 2) return count_nodes(m);
            return unique_edges(straight_simplices(m), execution).map([&](const auto& edges) {
                return m.points.size() + edges.size();
            });
        },
        mesh);
}

namespace {

template <int D>
Outcome<TransferredFields> transferred(const AnyMesh& to, const AnyMesh& from, std::vector<NamedField> fields,
                                       const TransferOptions& options, const Execution& execution) {
    const auto old_mesh = of_degree_2<D>(from, without_progress(execution));
    if (!old_mesh) return fail(old_mesh.error());
    const auto new_mesh = of_degree_2<D>(to, without_progress(execution));
    if (!new_mesh) return fail(new_mesh.error());
    std::vector<TransferField> specified;
    std::vector<std::string> names;
    for (const NamedField& field : fields) {
        specified.push_back(field.field);
        names.push_back(field.name);
    }
    auto result = transfer<D>(*old_mesh, specified, *new_mesh, options, execution);
    if (!result) return fail(result.error());
    for (std::size_t f = 0; f < fields.size(); ++f) fields[f].field = std::move(result->fields[f]);
    return TransferredFields{std::move(fields), {options.method, std::move(names), std::move(result->statistics)}};
}

struct NodesOfMesh {
    std::size_t vertices = 0;
    Column<std::array<VertexId, 2>> edges;
};
NodesOfMesh nodes_of(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return NodesOfMesh{m.points.size(), m.entities.edges}; }, mesh);
}

Column<double> at_all_nodes(const NodesOfMesh& nodes, const TransferField& field) {
    const auto width = static_cast<std::size_t>(field.components);
    Buffer<double> values(field.values.begin(), field.values.end());
    values.resize((nodes.vertices + nodes.edges.size()) * width, 0.0);  // a straight mesh has no nodes on its edges
    if (field.degree == 2) return Column<double>(std::move(values));
    for (std::size_t e = 0; e < nodes.edges.size(); ++e) {
        const auto& [a, b] = nodes.edges[e];
        for (std::size_t c = 0; c < width; ++c)
            values[(nodes.vertices + e) * width + c] =
                0.5 * (values[a.index() * width + c] + values[b.index() * width + c]);
    }
    return Column<double>(std::move(values));
}

}  // namespace

Outcome<TransferredFields> transfer_fields(const AnyMesh& new_mesh, const AnyMesh& old_mesh,
                                           std::vector<NamedField> fields, const TransferOptions& options,
                                           const StepWrapper& around) {
    return std::visit(
        [&]<int D, int Old>(const Mesh<D>&, const Mesh<Old>&) -> Outcome<TransferredFields> {
            if constexpr (D != Old)
                return fail(ErrorKind::input, "has another dimension than the old mesh", {}, {},
                            "give two meshes of the same domain");
            else
                return run_step(around, "transfer", [&](const Execution& e) {
                    return transferred<D>(new_mesh, old_mesh, std::move(fields), options, e);
                });
        },
        new_mesh, old_mesh);
}

std::vector<NamedField> at_vertices(const AnyMesh& mesh, std::vector<NamedField> fields) {
    const std::size_t vertices = nodes_of(mesh).vertices;
    for (NamedField& field : fields) {
        TransferField& specified = field.field;
        if (specified.degree == 1) continue;
        const auto count = static_cast<std::ptrdiff_t>(vertices * static_cast<std::size_t>(specified.components));
        specified.values = Column<double>(Buffer<double>(specified.values.begin(), specified.values.begin() + count));
        specified.degree = 1;
    }
    return fields;
}

MeshFields as_mesh_fields(const AnyMesh& mesh, std::span<const NamedField> fields) {
    const NodesOfMesh nodes = nodes_of(mesh);
    MeshFields all;
    for (const NamedField& field : fields)
        all = std::move(all).with({field.name, Centring::node, field.kind, at_all_nodes(nodes, field.field)});
    return all;
}

namespace {

template <int D>
Outcome<NamedField> evaluated(const QuadraticMesh<D>& mesh, const std::string& text, const Execution& execution) {
    const auto parsed = ScalarExpression<D>::parsed(text);
    if (!parsed) return fail(parsed.error());
    Buffer<Vec<D>> nodes(mesh.linear.points.begin(), mesh.linear.points.end());
    nodes.reserve(nodes.size() + mesh.edges.size());
    for (const LagrangeNode<D>& node : mesh.mid_nodes) nodes.push_back(node.point);
    Buffer<double> values(nodes.size());
    const auto done = each_chunk(
        execution, nodes.size(),
        [&](std::size_t begin, std::size_t end) {
            parsed->evaluator()(std::span(nodes).subspan(begin, end - begin),
                                std::span(values).subspan(begin, end - begin));
        },
        4096);
    if (!done) return fail(done.error());
    if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); }))
        return fail(ErrorKind::usage, "is not finite at a node of the mesh", quoted_expression(text), {},
                    "give an expression that is finite on the whole domain");
    return NamedField{"expression", FieldKind::scalar, {1, 2, Column<double>(std::move(values))}};
}

}  // namespace

Outcome<NamedField> field_of_expression(const AnyMesh& mesh, const std::string& expression,
                                        const Execution& execution) {
    return std::visit(
        [&]<int D>(const Mesh<D>&) -> Outcome<NamedField> {
            const auto quadratic = of_degree_2<D>(mesh, without_progress(execution));
            if (!quadratic) return fail(quadratic.error());
            return evaluated(*quadratic, expression, execution);
        },
        mesh);
}

template <int D>
Outcome<SolutionInput<D>> solution_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                      const StepWrapper& around) {
    const std::vector<double>& weights = source.weights;
    const auto check_weights = [&](std::size_t fields) -> Outcome<Done> {
        if (weights.empty() || weights.size() == fields) return Done{};
        return fail(ErrorKind::usage, fmt::format("there are {} weights, but {} fields", weights.size(), fields),
                    "/solution/weights", {}, "give one weight per field, or none");
    };
    SolutionInput<D> out;
    if (!source.expression.empty()) {
        const auto parsed = ScalarExpression<D>::parsed(source.expression);
        if (!parsed) return fail(parsed.error());
        if (auto fit = check_weights(1); !fit) return fail(fit.error());
        out.function = [expression = *parsed] { return expression.evaluator(); };
        return out;
    }
    if (source.fields.empty()) return out;
    const auto transferred =
        transfer_fields(AnyMesh(as_mesh(mesh)), source.mesh, source.fields, TransferOptions{}, around);
    if (!transferred) return fail(transferred.error());
    const std::vector<NamedField>& fields = transferred->fields;
    if (auto fit = check_weights(fields.size()); !fit) return fail(fit.error());
    for (std::size_t f = 0; f < fields.size(); ++f)
        for (Column<double>& scalar : scalars_of({&fields[f], 1}))
            out.fields.push_back({std::move(scalar), weights.empty() ? 1 : weights[f]});
    return out;
}

template Outcome<SolutionInput<2>> solution_on<2>(const SolutionSource&, const QuadraticMesh<2>&, const StepWrapper&);
template Outcome<SolutionInput<3>> solution_on<3>(const SolutionSource&, const QuadraticMesh<3>&, const StepWrapper&);

namespace {

template <int D>
Outcome<NamedField> as_field(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& logs, int degree,
                             const Execution& execution) {
    Column<LogMetric<D>> all = logs;
    if (degree == 2) {
        const auto nodal = framed_logs(mesh.edges, logs, execution);
        if (!nodal) return fail(nodal.error());
        Buffer<LogMetric<D>> joined(nodal->vertices.begin(), nodal->vertices.end());
        joined.insert(joined.end(), nodal->mid_nodes.begin(), nodal->mid_nodes.end());
        all = Column<LogMetric<D>>(std::move(joined));
    }
    return tensor_rows<D>(
               all.size(), [&](std::size_t n) { return all[n]; }, execution)
        .map([&](Column<double> values) {
            return NamedField{"metric", FieldKind::symmetric_tensor, {sym_size<D>, degree, std::move(values)}};
        });
}

MetricOfSolutionOptions options_of(const config::SolutionMetric& requested, bool at_nodes, double ridge_angle) {
    MetricOfSolutionOptions out;
    const int of_solution = at_nodes ? 2 : 1;
    out.norm = {.degree = requested.degree > 0 ? requested.degree : of_solution,
                .p = requested.norm,
                .error_of = requested.error_of};
    SolutionMetricOptions& metric = out.metric;
    for (const auto& [amount, of] : {std::pair(requested.complexity, TargetQuantity::complexity),
                                     std::pair(requested.vertices, TargetQuantity::vertices),
                                     std::pair(requested.elements, TargetQuantity::elements)})
        if (amount > 0) {
            metric.amount = amount;
            metric.of = of;
        }
    if (requested.gradation > 0) metric.gradation = GradationOptions{.ratio = requested.gradation};
    metric.min_size = requested.min_size;
    metric.max_size = requested.max_size;
    metric.max_anisotropy = requested.max_anisotropy;
    out.models.max_anisotropy = std::max(out.models.max_anisotropy, requested.max_anisotropy);
    out.sizes = requested.sizes;
    out.geometry = requested.geometry;
    out.ridge_angle = ridge_angle;
    out.expected = requested.expected;
    return out;
}

std::vector<double> weights_of_scalars(std::span<const NamedField> fields, std::span<const NamedField> selected,
                                       const std::vector<double>& weights) {
    std::vector<double> out;
    if (weights.size() != fields.size()) return out;
    for (const NamedField& field : selected) {
        const auto of = std::ranges::find(fields, field.name, &NamedField::name);
        out.insert(out.end(), static_cast<std::size_t>(field.field.components),
                   weights[static_cast<std::size_t>(of - fields.begin())]);
    }
    return out;
}

template <int D>
SolutionMetricReport report_of_metric(const MetricOfSolution<D>& result, const MetricOfSolutionOptions& options,
                                      double largest) {
    const SolutionMetric<D>& m = result.metric;
    return {.degree = options.norm.degree,
            .requested = m.requested,
            .complexity = m.reached,
            .elements = m.reached * elements_per_complexity<D>(),
            .fixed_complexity = m.fixed_complexity,
            .is_fixed_sufficient = m.is_fixed_sufficient,
            .is_reached = m.is_reached,
            .is_graded = m.is_graded,
            .evaluations = m.evaluations,
            .gradations = m.gradations,
            .largest_anisotropy = largest,
            .at_min = m.at_min,
            .at_max = m.at_max,
            .rows = result.rows,
            .from_inner_fits = result.from_inner_fits,
            .lower_degree = result.lower_degree,
            .zero_models = result.zero_models,
            .floored_models = result.floored_models,
            .models_max_anisotropy = options.models.max_anisotropy};
}

template <int D>
Outcome<std::vector<Column<LogMetric<D>>>> logs_of(std::span<const Solution> specified, std::size_t vertices,
                                                   const std::vector<config::FilePath>& names,
                                                   const Execution& execution) {
    std::vector<Column<LogMetric<D>>> out;
    for (std::size_t i = 0; i < specified.size(); ++i) {
        auto logs = log_metrics_of_file<D>({names[i].path, specified[i]}, vertices, execution);
        if (!logs) return fail(logs.error());
        out.push_back(std::move(logs->log_metrics));
    }
    return out;
}

/// Names of fields whose values look unordered. Errors (input): values certainly in another order than the nodes.
template <int D>
Outcome<std::vector<std::string>> unordered_fields(const QuadraticMesh<D>& mesh, std::span<const NamedField> fields,
                                                   const Execution& execution) {
    constexpr const char* remedy =
        "give one row per vertex, then one per edge by (lower vertex, higher vertex). A file with its own mesh, such "
        "as .vtu, is possible, too (docs/formats.md, Fields of degree 2)";
    std::vector<std::string> unordered;
    for (const NamedField& field : fields)
        for (const Column<double>& values : scalars_of({&field, 1})) {
            const auto check = check_node_order(mesh, values, execution);
            if (!check) return fail(check.error());
            const std::string nodes = "the values of " + field.name + " at the nodes of edges ";
            if (check->order == NodeOrder::by_first_element)
                return fail(ErrorKind::input,
                            nodes + "are in the order in which these edges first occur in the elements", {}, {},
                            remedy);
            if (check->order == NodeOrder::unrelated_mid_nodes)
                return fail(ErrorKind::input,
                            fmt::format("{}are in another order: their correlation with the values at the ends of "
                                        "their edges is {:.2f}, that of neighbouring vertices {:.2f}",
                                        nodes, check->between_ends_and_middle, check->between_vertices),
                            {}, {}, remedy);
            if (check->order == NodeOrder::unrelated && (unordered.empty() || unordered.back() != field.name))
                unordered.push_back(field.name);
        }
    return unordered;
}

struct FieldsMetric {
    std::span<const NamedField> fields;
    const config::SolutionMetric& options;
    std::span<const Solution> intersect;  ///< rows at the vertices
    double ridge_angle = 0;               ///< degrees
};

template <int D>
Outcome<SolutionMetricResult> compute_metric(const QuadraticMesh<D>& mesh, int mesh_degree, const FieldsMetric& request,
                                             const StepWrapper& around) {
    const auto& [fields, requested, specified, ridge_angle] = request;
    const bool at_nodes = fields.front().field.degree == 2;
    for (const NamedField& field : fields)
        if ((field.field.degree == 2) != at_nodes)
            return fail(ErrorKind::usage, "some fields are known only at the vertices", "fields", {},
                        "select fields that are known at the same nodes");
    const MetricOfSolutionOptions options = options_of(requested, at_nodes, ridge_angle);
    const auto logs = run_step(around, "fixed", [&](const Execution& e) {
        return logs_of<D>(specified, mesh.linear.points.size(), requested.intersect, e);
    });
    if (!logs) return fail(logs.error());
    auto unordered = run_step(around, "order", [&](const Execution& e) { return unordered_fields(mesh, fields, e); });
    if (!unordered) return fail(unordered.error());
    const auto scalars = scalars_of(fields);
    const auto result = metric_of_solution<D>(mesh, scalars, *logs, options, around);
    if (!result) return fail(result.error());
    return run_step(around, "metric", [&](const Execution& e) -> Outcome<SolutionMetricResult> {
        const auto largest = largest_anisotropy(result->metric.log_metrics, without_progress(e));
        if (!largest) return fail(largest.error());
        auto field = as_field(mesh, result->metric.log_metrics, mesh_degree, without_progress(e));
        if (!field) return fail(field.error());
        SolutionMetricReport report = report_of_metric(*result, options, *largest);
        report.unordered_fields = std::move(*unordered);
        return SolutionMetricResult{std::move(*field), std::move(report), result->bounds};
    });
}

}  // namespace

Outcome<SolutionMetricResult> metric_of_fields(const AnyMesh& mesh, std::span<const NamedField> fields,
                                               const config::SolutionMetric& requested,
                                               std::span<const Solution> specified, double ridge_angle,
                                               const StepWrapper& around) {
    if (fields.empty())
        return fail(ErrorKind::usage, "there is no solution for the metric", "/solution", {},
                    "give {\"file\": …}, a mesh file with fields at its nodes, or --solution on the command line");
    const auto selected = named({fields.begin(), fields.end()}, requested.fields, "fields");
    if (!selected) return fail(selected.error());
    config::SolutionMetric by = requested;
    by.expected.weights = weights_of_scalars(fields, *selected, requested.expected.weights);
    return std::visit(
        [&]<int D>(const Mesh<D>& m) -> Outcome<SolutionMetricResult> {
            if (plan_size(mesh).elements == 0)
                return fail(ErrorKind::input,
                            std::string("is on a mesh without ") + (D == 2 ? "triangles" : "tetrahedra") +
                                ": derivatives require fields in the volume",
                            {}, {}, "give a mesh of the volume");
            const auto quadratic =
                run_step(around, "elevate", [&](const Execution& e) { return of_degree_2<D>(mesh, e); });
            if (!quadratic) return fail(quadratic.error());
            return compute_metric<D>(*quadratic, m.degree, {*selected, by, specified, ridge_angle}, around);
        },
        mesh);
}

namespace {

/// One tensor per vertex, in the order of `Sym`.
template <int D>
Column<double> means_at_vertices(const RecoveredDerivatives<D>& recovered) {
    const MaterialRows& rows = recovered.rows;
    constexpr std::size_t width = Sym<D>{}.c.size();
    Buffer<double> values(rows.vertices() * width, 0.0);
    for (std::size_t v = 0; v < rows.vertices(); ++v) {
        const std::size_t first = rows.first(VertexId(v)), sides = rows.materials[VertexId(v)].size();
        for (std::size_t s = 0; s < sides; ++s)
            for (std::size_t k = 0; k < width; ++k)
                values[v * width + k] += recovered.fields[0].hessians[first + s].c[k] / static_cast<double>(sides);
    }
    return Column<double>(std::move(values));
}

}  // namespace

Outcome<Solution> hessians_of(const AnyMesh& mesh, const NamedField& field, const Execution& execution) {
    if (field.kind != FieldKind::scalar)
        return fail(ErrorKind::usage, "is not a scalar field", field.name, {}, "give one component");
    return std::visit(
        [&]<int D>(const Mesh<D>&) -> Outcome<Solution> {
            const auto quadratic = of_degree_2<D>(mesh, without_progress(execution));
            if (!quadratic) return fail(quadratic.error());
            const std::array<Column<double>, 1> values{field.field.values};
            const auto recovered = recover_derivatives<D>(*quadratic, values, {}, execution);
            if (!recovered) return fail(recovered.error());
            return Solution{
                D, {FieldKind::symmetric_tensor}, recovered->rows.vertices(), means_at_vertices(*recovered)};
        },
        mesh);
}

std::vector<std::string> solution_metric_notices(const SolutionMetricReport& r) {
    std::vector<std::string> notices;
    if (r.is_fixed_sufficient)
        notices.push_back(
            fmt::format("sizes by reference, geometry, bounds and gradation alone have the complexity {:.6g}: the "
                        "solution has no influence. Request a larger complexity or larger sizes",
                        r.fixed_complexity));
    else if (!r.is_reached)
        notices.emplace_back("the requested complexity is not reached: bounds or gradation prevent it");
    for (const std::string& field : r.unordered_fields)
        notices.push_back(fmt::format(
            "the values of {} at neighbouring nodes are as unrelated as in a random order. The mesh does not resolve "
            "the field, or its rows are in another order than the nodes (docs/formats.md, Fields of degree 2)",
            field));
    if (!r.is_graded) notices.emplace_back("the gradation ended early: some sizes still grow faster than requested");
    return notices;
}

std::vector<std::pair<std::string, IntegralReport>> TransferReport::integrals() const {
    std::vector<std::pair<std::string, IntegralReport>> all;
    for (std::size_t i = 0; i < names.size() && i < statistics.integrals.size(); ++i) {
        IntegralReport& report = all.emplace_back(names[i], IntegralReport{}).second;
        for (const MaterialIntegrals& of : statistics.integrals[i])
            for (std::size_t c = 0; c < of.before.size(); ++c) {
                report.largest = std::max(report.largest, std::abs(of.before[c]));
                report.largest_change = std::max(report.largest_change, std::abs(of.after[c] - of.before[c]));
            }
    }
    return all;
}

}  // namespace camber::run
