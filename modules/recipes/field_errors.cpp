module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
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
import camber.interpolation;
import camber.solution_metric;
import camber.io;
import camber.fields;
import camber.curving;
import camber.stages;

namespace camber::run {

namespace {

constexpr double max_hops = 8;

template <int D>
Outcome<std::vector<std::uint8_t>> boundary_vertices(const LinearMesh<D>& mesh, const Execution& execution) {
    std::vector<std::uint8_t> on(mesh.points.size(), 0);
    auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto across = neighbours(mesh, *around, execution);
    if (across) {
        for (const ElementFace& face : boundary_faces<D>(*across))
            for (const int i : face_opposite<D>(static_cast<int>(face.opposite)))
                on[mesh.elements.vertices[face.element][static_cast<std::size_t>(i)].index()] = 1;
        return on;
    }
    if (across.error().kind != ErrorKind::input) return fail(across.error());
    // Neighbours do not exist if a face has more than two elements. The file's facets are used then.
    for (const auto& facet : mesh.facets.vertices)
        for (const VertexId v : facet) on[v.index()] = 1;
    return on;
}

template <int D>
Outcome<std::vector<double>> hops_of_vertices(const QuadraticMesh<D>& mesh, const Execution& execution) {
    auto on = boundary_vertices(mesh.linear, execution);
    if (!on) return fail(on.error());
    std::vector<double> hops(on->size(), max_hops);
    for (std::size_t v = 0; v < hops.size(); ++v)
        if ((*on)[v] == 1) hops[v] = 0;
    for (double hop = 1; hop < max_hops; ++hop)
        for (const auto& [a, b] : mesh.edges.vertices) {
            double &first = hops[a.index()], &second = hops[b.index()];
            if (first == hop - 1) second = std::min(second, hop);
            if (second == hop - 1) first = std::min(first, hop);
        }
    return hops;
}

/// Bin k holds values below limit k that are not in the bin before; a last bin holds all larger values.
struct Bins {
    std::vector<double> limits;
    std::vector<std::string> ranges;  ///< one more than `limits`
};

Bins curvature_bins() {
    return {{1e-12, 1e-3, 1e-2, 0.03, 0.1},
            {"0", "below 0.001", "0.001 to 0.01", "0.01 to 0.03", "0.03 to 0.1", "0.1 and above"}};
}
Bins jacobian_bins() {
    return {{0, 0.1, 0.3, 0.5, 0.8, 1 - 1e-6},
            {"below 0", "0 to 0.1", "0.1 to 0.3", "0.3 to 0.5", "0.5 to 0.8", "0.8 to 1", "1: as straight"}};
}
Bins boundary_bins() {
    return {{1, 2, 3, 5, max_hops}, {"0: touches it", "1", "2", "3 or 4", "5 to 7", "8 and above"}};
}

std::vector<ErrorBin> binned(const Bins& bins, std::span<const double> kinds, const InterpolationError& errors) {
    std::vector<ErrorBin> all;
    all.reserve(bins.ranges.size());
    for (const std::string& range : bins.ranges) all.push_back({range});
    std::vector<std::size_t> at(kinds.size());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        at[e] = static_cast<std::size_t>(std::ranges::upper_bound(bins.limits, kinds[e]) - bins.limits.begin());
        ++all[at[e]].elements;
    }
    const auto add_shares = [&](double ErrorBin::* share, const ErrorNorm& norm) {
        double sum = 0;
        for (std::size_t e = 0; e < at.size(); ++e) {
            all[at[e]].*share += norm.squares[e];
            sum += norm.squares[e];
        }
        for (ErrorBin& bin : all) bin.*share /= sum > 0 ? sum : 1;
    };
    add_shares(&ErrorBin::straight, errors.straight.l2);
    add_shares(&ErrorBin::same_boundary, errors.same_boundary.l2);
    add_shares(&ErrorBin::curved, errors.curved.l2);
    return all;
}

struct ElementKinds {
    Buffer<double> curvature;        ///< largest |node − middle|/|chord| of its edges
    Buffer<double> scaled_jacobian;  ///< minimum over the element
    Buffer<double> hops;             ///< number of edges to the boundary, at most 8
};
template <int D>
Outcome<ElementKinds> element_kinds(const QuadraticMesh<D>& mesh, const Column<float>& min_scaled_jacobian,
                                    const Execution& execution) {
    auto hops = hops_of_vertices(mesh, execution);
    if (!hops) return fail(hops.error());
    const std::size_t elements = mesh.linear.elements.size();
    ElementKinds kinds{Buffer<double>(elements), Buffer<double>(elements), Buffer<double>(elements)};
    auto done = each(execution, elements, [&](std::size_t e) {
        double bent = 0, nearest = max_hops;
        for (const EdgeId edge : mesh.edges.of_elements[e]) bent = std::max(bent, curvature(edge_of(mesh, edge)));
        for (const VertexId v : mesh.linear.elements.vertices[e]) nearest = std::min(nearest, (*hops)[v.index()]);
        kinds.curvature[e] = bent;
        kinds.hops[e] = nearest;
        kinds.scaled_jacobian[e] = static_cast<double>(min_scaled_jacobian[e]);
    });
    if (!done) return fail(done.error());
    return kinds;
}

template <int D>
Outcome<FieldErrors> errors_of(const QuadraticMesh<D>& mesh, const std::string& expression, const ElementKinds& kinds,
                               const Execution& execution) {
    const auto parsed = ScalarExpression<D>::parsed(expression);
    if (!parsed) return fail(parsed.error());
    const ScalarField<D> field = [&] { return parsed->evaluator(); };
    auto errors = interpolation_error<D>(as_mesh(mesh), field, {}, execution);
    if (!errors) {
        Error error = errors.error();
        if (error.kind == ErrorKind::usage) error.where = quoted_expression(expression);
        return fail(std::move(error));
    }
    return FieldErrors{expression, *errors, binned(curvature_bins(), kinds.curvature, *errors),
                       binned(jacobian_bins(), kinds.scaled_jacobian, *errors),
                       binned(boundary_bins(), kinds.hops, *errors)};
}

}  // namespace

ErrorRatios ratios_of(const InterpolationError& e) {
    const auto ratio = [](const ErrorNorm& compared, const ErrorNorm& curved) {
        const bool is_known = curved.value > 4 * curved.rounding && compared.value > 4 * compared.rounding;
        return is_known ? std::optional(compared.value / curved.value) : std::nullopt;
    };
    return {ratio(e.compared().l2, e.curved.l2), ratio(e.compared().h1, e.curved.h1)};
}

template <int D>
Outcome<std::vector<FieldErrors>> field_errors(const QuadraticMesh<D>& mesh, const Column<float>& min_scaled_jacobian,
                                               const std::vector<std::string>& expressions, const StepWrapper& around) {
    const auto kinds =
        run_step(around, "classify", [&](const Execution& e) { return element_kinds(mesh, min_scaled_jacobian, e); });
    if (!kinds) return fail(kinds.error());
    std::vector<FieldErrors> all;
    for (const std::string& expression : expressions) {
        auto errors =
            run_step(around, "interpolate", [&](const Execution& e) { return errors_of(mesh, expression, *kinds, e); });
        if (!errors) return fail(errors.error());
        all.push_back(std::move(*errors));
    }
    return all;
}

template Outcome<std::vector<FieldErrors>> field_errors<2>(const QuadraticMesh<2>&, const Column<float>&,
                                                           const std::vector<std::string>&, const StepWrapper&);
template Outcome<std::vector<FieldErrors>> field_errors<3>(const QuadraticMesh<3>&, const Column<float>&,
                                                           const std::vector<std::string>&, const StepWrapper&);

namespace {

/// Vertices come first. Values known only at vertices are linear along edges.
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
    const auto error =
        function_error<D>(as_mesh(*quadratic), at_nodes(*quadratic, values, degree), field, {}, execution);
    if (!error) {
        Error explained = error.error();
        if (explained.kind == ErrorKind::usage) explained.where = quoted_expression(exact);
        return fail(std::move(explained));
    }
    return CycleError{error->l2.value, error->h1.value};
}

Outcome<CycleError> error_of(const AnyMesh& mesh, std::span<const double> values, int degree, const std::string& exact,
                             const Execution& execution) {
    return std::visit(
        [&]<int D>(const Mesh<D>&) { return error_on<D>(mesh, values, degree, exact, without_progress(execution)); },
        mesh);
}

int degree_of(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return m.degree; }, mesh);
}

template <int D>
Outcome<double> expected_on_straight(const LinearMesh<D>& mesh, const SolutionSource& source,
                                     const Execution& execution) {
    const auto quadratic = elevate(mesh, execution);
    if (!quadratic) return fail(quadratic.error());
    const auto specified = solution_on(source, *quadratic, without_wrapper(execution));
    if (!specified) return fail(specified.error());
    const auto known = known_solution(*quadratic, *specified, *quadratic, execution);
    if (!known) return fail(known.error());
    return expected_error(mesh, *known, source.fields.front().field.degree, execution);
}

int interpolated_degree(const AnyMesh& mesh, std::span<const NamedField> solved, const config::Metric& metric) {
    int degree = degree_of(mesh);
    for (const NamedField& field : solved) degree = std::max(degree, field.field.degree);
    const auto* const result = std::get_if<config::SolutionMetric>(&metric);
    return result == nullptr ? degree : std::max(degree, result->degree);
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
                    "remove the exact solution");
    return error_of(mesh, scalar->field.values, scalar->field.degree, exact, execution);
}

/// L2 error of the interpolant, expected from fields on a straight mesh; none for degree 2.
Outcome<std::optional<double>> error_expected_on(const AnyMesh& mesh, std::span<const NamedField> fields,
                                                 const std::vector<double>& weights, const Execution& execution) {
    return std::visit(
        [&](const auto& m) -> Outcome<std::optional<double>> {
            if (m.degree > 1) return std::nullopt;
            return expected_on_straight(straight_simplices(m), {mesh, {fields.begin(), fields.end()}, {}, weights},
                                        without_progress(execution))
                .map([](double error) { return std::optional(error); });
        },
        mesh);
}

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
