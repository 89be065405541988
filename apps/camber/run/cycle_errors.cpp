module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.curving;
import camber.fields;
import camber.interpolation;
import camber.io;
import camber.recipes;
import camber.solution_metric;
import :cycles;
import :solution;
import :solution_source;

namespace camber::run {

namespace {

/// At all nodes, vertices first; what is known at the vertices alone is linear along edges.
template <int D>
Buffer<double> at_nodes(const QuadraticMesh<D>& mesh, std::span<const double> values, int degree) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<double> all(values.begin(), values.end());
    all.resize(vertices + mesh.edges.size(), 0.0);
    if (degree == 2) return all;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        all[vertices + e] = (all[a.index()] + all[b.index()]) / 2;
    }
    return all;
}

template <int D>
Outcome<CycleError> error_on(const AnyMesh& mesh, std::span<const double> values, int degree, const std::string& exact,
                             const Execution& execution) {
    const auto quadratic = of_degree_2<D>(mesh, execution);
    if (!quadratic) return fail(quadratic.error());
    const auto parsed = ScalarExpression<D>::parsed(exact);
    if (!parsed) return fail(parsed.error());
    const ScalarField<D> field = [&] { return parsed->evaluator(); };
    const auto error = function_error<D>(*quadratic, at_nodes(*quadratic, values, degree), field, {}, execution);
    if (!error) {
        Error told = error.error();
        if (told.kind == ErrorKind::usage) told.where = quoted_expression(exact);
        return fail(std::move(told));
    }
    return CycleError{error->l2.value, error->h1.value};
}

Outcome<CycleError> error_of(const AnyMesh& mesh, std::span<const double> values, int degree, const std::string& exact,
                             const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh&) {
            return error_on<Mesh::dimension>(mesh, values, degree, exact, without_progress(execution));
        },
        mesh);
}

int degree_of(const AnyMesh& mesh) {
    return std::visit(
        [](const auto& m) {
            if constexpr (requires { m.linear; })
                return 2;
            else
                return 1;
        },
        mesh);
}

template <int D>
Outcome<double> expected_on_straight(const LinearMesh<D>& mesh, const SolutionSource& source,
                                     const Execution& execution) {
    const auto quadratic = elevate(mesh, execution);
    if (!quadratic) return fail(quadratic.error());
    const auto given = solution_on(source, *quadratic, plainly(execution));
    if (!given) return fail(given.error());
    const auto known = known_solution(*quadratic, *given, *quadratic, execution);
    if (!known) return fail(known.error());
    return expected_error(mesh, *known, source.fields.front().field.degree, execution);
}

int interpolated_degree(const AnyMesh& mesh, std::span<const NamedField> solved, const config::Metric& metric) {
    int degree = degree_of(mesh);
    for (const NamedField& field : solved) degree = std::max(degree, field.field.degree);
    const auto* const made = std::get_if<config::SolutionMetric>(&metric);
    return made == nullptr ? degree : std::max(degree, made->degree);
}

Outcome<CycleError> error_of_interpolant(const AnyMesh& mesh, int degree, const std::string& exact,
                                         const Execution& execution) {
    const auto field = field_of_expression(mesh, exact, execution);
    if (!field) return fail(field.error());
    return error_of(mesh, field->field.values, degree, exact, execution);
}

Outcome<CycleError> error_of_solution(const AnyMesh& mesh, std::span<const NamedField> fields, const std::string& exact,
                                      const Execution& execution) {
    const auto scalar = std::ranges::find(fields, 1, [](const NamedField& f) { return f.field.components; });
    if (scalar == fields.end())
        return fail(ErrorKind::input, "has no scalar field to compare with the exact solution", {}, {},
                    "leave the exact solution out");
    return error_of(mesh, scalar->field.values, scalar->field.degree, exact, execution);
}

/// The L2 error of the interpolant that fields on a straight mesh let expect; none of a mesh of degree 2.
Outcome<std::optional<double>> error_expected_on(const AnyMesh& mesh, std::span<const NamedField> fields,
                                                 const std::vector<double>& weights, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh& m) -> Outcome<std::optional<double>> {
            if constexpr (requires { m.linear; })
                return std::nullopt;
            else
                return expected_on_straight(m, {mesh, {fields.begin(), fields.end()}, {}, weights},
                                            without_progress(execution))
                    .map([](double error) { return std::optional(error); });
        },
        mesh);
}

/// Errors where the exact solution is known.
Outcome<Done> add_true_errors(CycleRow& row, const AnyMesh& mesh, int degree, std::span<const NamedField> solved,
                              const std::string& exact, const Execution& execution) {
    const auto interpolated = error_of_interpolant(mesh, degree, exact, execution);
    if (!interpolated) return fail(interpolated.error());
    row.interpolated = *interpolated;
    if (solved.empty()) return Done{};
    const auto error = error_of_solution(mesh, solved, exact, execution);
    if (!error) return fail(error.error());
    row.solved = *error;
    return Done{};
}

}  // namespace

Outcome<Done> add_errors(CycleRow& row, const AnyMesh& mesh, std::span<const NamedField> solved,
                         const config::Pipeline& pipeline, const Execution& execution) {
    const int degree = interpolated_degree(mesh, solved, pipeline.metric);
    if (degree == 2) {
        const auto nodes = nodes_in_degree_2(mesh, without_progress(execution));
        if (!nodes) return fail(nodes.error());
        row.unknowns = *nodes;
    }
    if (!solved.empty()) {
        const auto expected = error_expected_on(mesh, solved, pipeline.solution.weights, execution);
        if (!expected) return fail(expected.error());
        if (*expected) row.expected = *expected;
    }
    const std::string& exact = pipeline.adapt.exact;
    return exact.empty() ? Done{} : add_true_errors(row, mesh, degree, solved, exact, execution);
}

}  // namespace camber::run
