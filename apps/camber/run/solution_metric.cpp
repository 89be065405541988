module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.recovery;
import camber.solution_metric;
import camber.transfer;
import :plan;
import :solution;
import :solution_report;
import :stages;

namespace camber::run {

namespace {

/// At the vertices, or at all nodes.
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
    Buffer<double> values;
    values.reserve(all.size() * sym_size<D>);
    for (const LogMetric<D>& log_metric : all) {
        const Sym<D> tensor = exp(log_metric).m;
        values.insert(values.end(), tensor.c.begin(), tensor.c.end());
    }
    return NamedField{"metric", FieldKind::symmetric_tensor, {sym_size<D>, degree, Column<double>(std::move(values))}};
}

MetricOfSolutionOptions options_of(const config::SolutionMetric& asked, bool at_nodes, double ridge_angle) {
    MetricOfSolutionOptions out;
    const int of_solution = at_nodes ? 2 : 1;
    out.norm = {.degree = asked.degree > 0 ? asked.degree : of_solution, .p = asked.norm, .error_of = asked.error_of};
    SolutionMetricOptions& metric = out.metric;
    for (const auto& [amount, of] :
         {std::pair(asked.complexity, AmountOf::complexity), std::pair(asked.vertices, AmountOf::vertices),
          std::pair(asked.elements, AmountOf::elements)})
        if (amount > 0) {
            metric.amount = amount;
            metric.of = of;
        }
    if (asked.gradation > 0) metric.gradation = GradationOptions{.ratio = asked.gradation};
    metric.min_size = asked.min_size;
    metric.max_size = asked.max_size;
    metric.max_anisotropy = asked.max_anisotropy;
    out.models.max_anisotropy = std::max(out.models.max_anisotropy, asked.max_anisotropy);
    out.sizes = asked.sizes;
    out.geometry = asked.geometry;
    out.ridge_angle = ridge_angle;
    out.expected = asked.expected;
    return out;
}

/// Weights of the scalars of fields, by those of the solution's fields, which stand in its order.
std::vector<double> weights_of_scalars(std::span<const NamedField> fields, std::span<const NamedField> wanted,
                                       const std::vector<double>& weights) {
    std::vector<double> out;
    if (weights.size() != fields.size()) return out;
    for (const NamedField& field : wanted) {
        const auto of = std::ranges::find(fields, field.name, &NamedField::name);
        out.insert(out.end(), static_cast<std::size_t>(field.field.components),
                   weights[static_cast<std::size_t>(of - fields.begin())]);
    }
    return out;
}

template <int D>
SolutionMetricReport told(const MetricOfSolution<D>& made, const MetricOfSolutionOptions& options, double largest) {
    const SolutionMetric<D>& m = made.metric;
    return {.degree = options.norm.degree,
            .asked = m.asked,
            .complexity = m.reached,
            .elements = m.reached * elements_per_complexity<D>(),
            .of_fixed = m.of_fixed,
            .is_fixed_alone = m.is_fixed_alone,
            .is_reached = m.is_reached,
            .is_graded = m.is_graded,
            .evaluations = m.evaluations,
            .gradations = m.gradations,
            .largest_anisotropy = largest,
            .at_min = m.at_min,
            .at_max = m.at_max,
            .rows = made.rows,
            .from_inner_fits = made.from_inner_fits,
            .lower_degree = made.lower_degree,
            .zero_models = made.zero_models,
            .floored_models = made.floored_models,
            .models_max_anisotropy = options.models.max_anisotropy};
}

template <int D>
Outcome<std::vector<Column<LogMetric<D>>>> logs_of(std::span<const Solution> given, std::size_t vertices,
                                                   const std::vector<config::FilePath>& names,
                                                   const Execution& execution) {
    std::vector<Column<LogMetric<D>>> out;
    for (std::size_t i = 0; i < given.size(); ++i) {
        auto logs = log_metrics_of_file<D>({names[i].path, given[i]}, vertices, execution);
        if (!logs) return fail(logs.error());
        out.push_back(std::move(logs->log_metrics));
    }
    return out;
}

/// The names of fields whose values are as unrelated as in a random order. Errors (input): values that are certainly in
/// another order than the nodes.
template <int D>
Outcome<std::vector<std::string>> fields_in_doubt(const QuadraticMesh<D>& mesh, std::span<const NamedField> fields,
                                                  const Execution& execution) {
    constexpr const char* remedy =
        "give a row for each vertex, then one for each edge by (lower vertex, higher vertex), or a file with its "
        "own mesh, such as .vtu (docs/formats.md, Fields of degree 2)";
    std::vector<std::string> in_doubt;
    for (const NamedField& field : fields)
        for (const Column<double>& values : scalars_of({&field, 1})) {
            const auto check = check_node_order(mesh, values, execution);
            if (!check) return fail(check.error());
            const std::string nodes = "the values of " + field.name + " at the nodes of edges ";
            if (check->order == NodeOrder::by_first_element)
                return fail(ErrorKind::input,
                            nodes + "are in the order in which elements, one after the other, first have these edges",
                            {}, {}, remedy);
            if (check->order == NodeOrder::unrelated_mid_nodes)
                return fail(ErrorKind::input,
                            fmt::format("{}are in another order: their correlation with the values at the ends of "
                                        "their edges is {:.2f}, that of neighbouring vertices {:.2f}",
                                        nodes, check->between_ends_and_middle, check->between_vertices),
                            {}, {}, remedy);
            if (check->order == NodeOrder::unrelated && (in_doubt.empty() || in_doubt.back() != field.name))
                in_doubt.push_back(field.name);
        }
    return in_doubt;
}

template <int D>
Outcome<SolutionMetricMade> made_metric(const QuadraticMesh<D>& mesh, int mesh_degree,
                                        std::span<const NamedField> fields, const config::SolutionMetric& asked,
                                        std::span<const Solution> given, double ridge_angle, const Around& around) {
    const bool at_nodes = fields.front().field.degree == 2;
    for (const NamedField& field : fields)
        if ((field.field.degree == 2) != at_nodes)
            return fail(ErrorKind::usage, "some fields are known at the vertices only", "fields", {},
                        "name those that are known alike");
    const MetricOfSolutionOptions options = options_of(asked, at_nodes, ridge_angle);
    const auto logs = run_step(around, "fixed", [&](const Execution& e) {
        return logs_of<D>(given, mesh.linear.points.size(), asked.intersect, e);
    });
    if (!logs) return fail(logs.error());
    auto in_doubt = run_step(around, "order", [&](const Execution& e) { return fields_in_doubt(mesh, fields, e); });
    if (!in_doubt) return fail(in_doubt.error());
    const auto scalars = scalars_of(fields);
    const auto made = metric_of_solution<D>(mesh, scalars, *logs, options, around);
    if (!made) return fail(made.error());
    return run_step(around, "metric", [&](const Execution& e) -> Outcome<SolutionMetricMade> {
        const auto largest = largest_anisotropy(made->metric.log_metrics, without_progress(e));
        if (!largest) return fail(largest.error());
        auto field = as_field(mesh, made->metric.log_metrics, mesh_degree, without_progress(e));
        if (!field) return fail(field.error());
        SolutionMetricReport report = told(*made, options, *largest);
        report.fields_in_doubt = std::move(*in_doubt);
        return SolutionMetricMade{std::move(*field), std::move(report), made->bounds};
    });
}

}  // namespace

Outcome<SolutionMetricMade> metric_of_fields(const AnyMesh& mesh, std::span<const NamedField> fields,
                                             const config::SolutionMetric& asked, std::span<const Solution> given,
                                             double ridge_angle, const Around& around) {
    if (fields.empty())
        return fail(ErrorKind::usage, "there is no solution that the metric could be made for", "/solution", {},
                    "give {\"file\": …}, or a mesh file with fields at its nodes; --solution on the command line");
    const auto wanted = named({fields.begin(), fields.end()}, asked.fields, "fields");
    if (!wanted) return fail(wanted.error());
    config::SolutionMetric by = asked;
    by.expected.weights = weights_of_scalars(fields, *wanted, asked.expected.weights);
    return std::visit(
        [&]<class Mesh>(const Mesh&) -> Outcome<SolutionMetricMade> {
            constexpr int D = Mesh::dimension;
            constexpr int degree = requires(const Mesh& m) { m.linear; } ? 2 : 1;
            if (plan_size(mesh).elements == 0)
                return fail(ErrorKind::input,
                            std::string("is of a mesh without ") + (D == 2 ? "triangles" : "tetrahedra") +
                                ": derivatives are those of fields in the volume",
                            {}, {}, "give a mesh of the volume");
            const auto quadratic =
                run_step(around, "elevate", [&](const Execution& e) { return of_degree_2<D>(mesh, e); });
            if (!quadratic) return fail(quadratic.error());
            return made_metric<D>(*quadratic, degree, *wanted, by, given, ridge_angle, around);
        },
        mesh);
}

}  // namespace camber::run
