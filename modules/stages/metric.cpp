// Known solutions, sizes by geometry, metric of a solution.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.stages;
import camber.core;
import camber.bezier;
import camber.recovery;
import camber.metric;
import camber.solution_metric;
import camber.surface;
import camber.operation;
import camber.curving;

namespace camber {

static_assert(lattice_degree == known_degree);

namespace {

template <int D>
Outcome<KnownSolution<D>> of_fields(const QuadraticMesh<D>& mesh, std::span<const WeightedField> fields,
                                    const QuadraticMesh<D>& curved, const Execution& execution) {
    std::vector<Column<double>> values;
    for (const WeightedField& field : fields) values.push_back(in_unit_range(field.values));
    auto known = element_values<D>(mesh, values, curved, execution);
    if (!known) return fail(known.error());
    KnownSolution<D> out;
    for (std::size_t f = 0; f < fields.size(); ++f)
        out.push_back({std::move((*known)[f]), fields[f].weight, range_exponent(fields[f].values)});
    return out;
}

template <int D>
Outcome<KnownSolution<D>> of_function(const QuadraticMesh<D>& mesh, const FunctionOfPosition<D>& function,
                                      const Execution& execution) {
    auto values = element_values(mesh, function, execution);
    if (!values) return fail(values.error());
    return KnownSolution<D>{{.values = std::move(values->rows), .exponent = values->exponent}};
}

}  // namespace

template <int D>
Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const SolutionInput<D>& specified,
                                         const QuadraticMesh<D>& curved, const Execution& execution) {
    return specified.function ? of_function(curved, specified.function, execution)
                              : of_fields<D>(mesh, specified.fields, curved, execution);
}

template Outcome<KnownSolution<2>> known_solution<2>(const QuadraticMesh<2>&, const SolutionInput<2>&,
                                                     const QuadraticMesh<2>&, const Execution&);
template Outcome<KnownSolution<3>> known_solution<3>(const QuadraticMesh<3>&, const SolutionInput<3>&,
                                                     const QuadraticMesh<3>&, const Execution&);

namespace {

template <int D>
Outcome<Column<std::uint32_t>> requested_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                                 const std::vector<Reference>& references) {
    if (references.empty()) return features.patches;
    const auto& of = mesh.facets.references;
    for (const Reference r : references)
        if (std::ranges::find(of, r) == of.end())
            return fail(ErrorKind::usage, "no facet has the reference " + std::to_string(r), {}, {},
                        "camber info lists the references of the mesh");
    Buffer<std::uint32_t> patches(of.size());
    for (std::size_t f = 0; f < patches.size(); ++f)
        patches[f] = std::ranges::find(references, of[f]) == references.end() ? no_patch : features.patches[f];
    return Column<std::uint32_t>(std::move(patches));
}

template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> sizes_of(const auto& mesh, const LinearMesh<D>& linear,
                                                    const Features<D>& features, const GeometrySizes& requested,
                                                    double largest, const Execution& execution) {
    if (!requested.are_requested())
        return fail(ErrorKind::usage, "the geometry determines no sizes", {}, {},
                    "give chord_error, angle or gap_elements");
    const auto patches = requested_patches(linear, features, requested.references);
    if (!patches) return fail(patches.error());
    std::vector<MetricsAtVertices<D>> parts;
    if (requested.gap_elements > 0) {
        auto across =
            gap_metrics(linear, *patches, {.elements = requested.gap_elements}, largest, part_of(execution, 0, 0.5));
        if (!across) return fail(across.error());
        parts.push_back(std::move(*across));
    }
    if (!(requested.chord_error > 0) && !(requested.angle > 0)) return parts;
    const ChordOptions options{requested.chord_error, requested.angle, requested.normal_ratio};
    auto chords = chord_metrics(mesh, *patches, options, largest, part_of(execution, 0.5, 1));
    if (!chords) return fail(chords.error());
    parts.push_back(std::move(*chords));
    return parts;
}

}  // namespace

template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const LinearMesh<D>& mesh, const Features<D>& features,
                                                          const GeometrySizes& requested, double largest,
                                                          const Execution& execution) {
    return sizes_of(mesh, mesh, features, requested, largest, execution);
}
template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                          const GeometrySizes& requested, double largest,
                                                          const Execution& execution) {
    return sizes_of(mesh, mesh.linear, features, requested, largest, execution);
}

namespace {

template <int D>
bool is_straight(const QuadraticMesh<D>& mesh) {
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[EdgeId(e)];
        if (mesh.mid_nodes[EdgeId(e)].point != midpoint(mesh.linear.points[a], mesh.linear.points[b])) return false;
    }
    return true;
}

template <int D>
class Models {
  public:
    Models(const QuadraticMesh<D>& mesh, const RecoveredDerivatives<D>& derivatives,
           const MetricOfSolutionOptions& options)
        : mesh_(mesh), derivatives_(derivatives), options_(options), is_straight_(camber::is_straight(mesh)) {}

    [[nodiscard]] bool is_straight() const { return is_straight_; }
    [[nodiscard]] Outcome<LocalModels<D>> of(const FieldDerivatives<D>& field, const Incidence<ElementId>& around,
                                             double complexity, double largest, const Execution& execution) const {
        if (is_straight_ && derivatives_.rows.size() == mesh_.linear.points.size())
            return options_.norm.degree == 1 ? hessian_models<D>(field.hessians, options_.models, execution)
                                             : cubic_models<D>(field.thirds, options_.models, execution);
        auto elements = of_elements(field, part_of(execution, 0, 0.7));
        if (!elements) return elements;
        if (elements->zero == elements->rows.size()) {
            elements->rows = Buffer<LocalModel<D>>(mesh_.linear.points.size(), zero_model<D>());
            return elements;
        }
        auto rows = models_at_vertices(mesh_.linear, around, elements->rows, {options_.norm, complexity, largest},
                                       part_of(execution, 0.7, 1));
        if (!rows) return fail(rows.error());
        elements->rows = std::move(*rows);
        return elements;
    }

  private:
    [[nodiscard]] Outcome<LocalModels<D>> of_elements(const FieldDerivatives<D>& field,
                                                      const Execution& execution) const {
        const auto mean = [&](const auto& values) {
            const auto row = [&](ElementId e, int i) { return row_of(derivatives_.rows, mesh_.linear, e, i); };
            return element_means(mesh_.linear, values, row, without_progress(execution));
        };
        const auto hessians = mean(field.hessians);
        if (!hessians) return fail(hessians.error());
        if (options_.norm.degree == 1) {
            const auto gradients = mean(field.gradients);
            if (!gradients) return fail(gradients.error());
            return curved_hessian_models(mesh_, *gradients, *hessians, options_.models, execution);
        }
        const auto thirds = mean(field.thirds);
        if (!thirds) return fail(thirds.error());
        return curved_cubic_models(mesh_, *hessians, *thirds, options_.models, execution);
    }

    const QuadraticMesh<D>& mesh_;
    const RecoveredDerivatives<D>& derivatives_;
    const MetricOfSolutionOptions& options_;
    bool is_straight_;
};

template <int D>
Outcome<Column<LogMetric<D>>> fixed_part(const QuadraticMesh<D>& mesh, bool is_straight,
                                         std::span<const Column<LogMetric<D>>> specified,
                                         const MetricOfSolutionOptions& options, double largest,
                                         const Execution& execution) {
    std::vector<MetricsAtVertices<D>> parts;
    if (!options.sizes.empty()) {
        auto sizes = sizes_by_reference(mesh.linear, options.sizes);
        if (!sizes) return fail(sizes.error());
        parts.push_back(std::move(*sizes));
    }
    if (options.geometry.are_requested()) {
        const auto features = find_features(mesh.linear, mesh.edges,
                                            FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle}, execution);
        if (!features) return fail(features.error());
        auto own = is_straight ? geometry_sizes(mesh.linear, *features, options.geometry, largest, execution)
                               : geometry_sizes(mesh, *features, options.geometry, largest, execution);
        if (!own) return fail(own.error());
        std::ranges::move(*own, std::back_inserter(parts));
    }
    if (parts.empty() && specified.empty()) return Column<LogMetric<D>>{};
    return fixed_metric<D>(mesh.linear, parts, specified, largest, execution);
}

template <int D>
Buffer<double> longest_edges(const QuadraticMesh<D>& mesh) {
    Buffer<double> longest(mesh.linear.points.size(), 0.0);
    for (const auto& [a, b] : mesh.edges.vertices) {
        const double length = distance(mesh.linear.points[a], mesh.linear.points[b]);
        for (const VertexId v : {a, b}) longest[v.index()] = std::max(longest[v.index()], length);
    }
    return longest;
}

/// True if the interpolation error is within rounding of the field's range everywhere; a metric would then be noise.
/// The error is |d^{k+1}u| h^{k+1} for elements of degree k, longest edges h and a field u.
template <int D>
bool is_exact(const MaterialRows& rows, const Buffer<double>& longest, const FieldDerivatives<D>& field,
              const Column<double>& values, int degree) {
    constexpr double rounding = 1e-10;
    if (values.empty()) return true;
    const double range = std::ranges::max(values) - std::ranges::min(values);
    for (std::size_t v = 0; v < longest.size(); ++v)
        for (std::size_t i = 0; i < rows.materials[v].size(); ++i) {
            const std::size_t row = rows.first(VertexId(v)) + i;
            const double h = longest[v];
            const double error = degree == 1 ? norm(field.hessians[row]) * h * h : norm(field.thirds[row]) * h * h * h;
            if (error > rounding * range) return false;
        }
    return true;
}

/// Weights for derivatives in units in which each field's range is about 1. A single field's weight refers to the
/// user's unit and is converted.
std::vector<double> weights_of(const ExpectedError& expected, std::span<const Column<double>> fields) {
    std::vector<double> weights = expected.weights;
    weights.resize(fields.size(), 1.0);
    if (fields.size() == 1) weights[0] = std::scalbn(weights[0], range_exponent(fields[0].view()));
    return weights;
}

double range_of(std::span<const Column<double>> fields, std::span<const double> weights) {
    double sum = 0;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        const auto [least, largest] = std::minmax_element(fields[f].begin(), fields[f].end());
        const double range = weights[f] * (*largest - *least);
        sum += range * range;
    }
    return std::sqrt(sum);
}

/// If the boundary is at distance δ from the geometry, the solution u has an error of about δ |∂u/∂n| there, with the
/// normal derivative ∂u/∂n. With the range of u, this error extends into the domain by at most range/|∂u/∂n|, and by at
/// most volume/area. So its squared L2 norm is at most δ² min(range ∫ |∂u/∂n|, volume/area ∫ (∂u/∂n)²).
template <int D>
Outcome<std::vector<DistanceBound>> bounds_by_error(const QuadraticMesh<D>& mesh, double l2, double range,
                                                    std::span<const NormalGradients> gradients,
                                                    const Execution& execution) {
    const auto volume = complexity(
        mesh.linear, Column<LogMetric<D>>(Buffer<LogMetric<D>>(mesh.linear.points.size(), LogMetric<D>{})), execution);
    if (!volume) return fail(volume.error());
    std::vector<DistanceBound> bounds;
    for (const NormalGradients& of : gradients) {
        const double change = std::sqrt(std::min(range * of.integral, *volume / of.area * of.squares));
        if (const double bound = l2 / change; change > 0 && std::isfinite(bound) && bound > 0)
            bounds.push_back({bound, {of.reference}});
    }
    return bounds;
}

SolutionMetricOptions with_amount(SolutionMetricOptions options, std::size_t elements) {
    if (options.amount > 0) return options;
    options.amount = static_cast<double>(elements);
    options.of = TargetQuantity::elements;
    return options;
}

}  // namespace

template <int D>
Outcome<MetricOfSolution<D>> metric_of_solution(const QuadraticMesh<D>& mesh,
                                                std::span<const Column<double>> input_fields,
                                                std::span<const Column<LogMetric<D>>> specified,
                                                const MetricOfSolutionOptions& options, const StepWrapper& around) {
    const SolutionMetricOptions metric = with_amount(options.metric, mesh.linear.elements.size());
    const double complexity = complexity_of<D>(metric.amount, metric.of);
    const double largest = metric.max_size > 0 ? metric.max_size : diameter(mesh.linear);
    MetricOfSolution<D> out;
    std::vector<Column<double>> fields;
    for (const Column<double>& field : input_fields) fields.push_back(in_unit_range(field));
    const auto derivatives = run_step(around, "recover", [&](const Execution& e) {
        return recover_derivatives<D>(mesh, fields, options.recovery, e);
    });
    if (!derivatives) return fail(derivatives.error());
    if (options.norm.degree > derivatives->degree)
        return fail(ErrorKind::usage,
                    "elements of degree 2 need third derivatives, but the field has values only at the vertices",
                    "degree", {}, "request elements of degree 1, or give a field at all nodes of a mesh of degree 2");
    out.rows = derivatives->rows.size();
    out.from_inner_fits = derivatives->from_inner_fits;
    out.lower_degree = derivatives->lower_degree;
    const Models<D> models(mesh, *derivatives, options);
    std::vector<SolutionField<D>> parts;
    auto result = run_step(around, "models", [&](const Execution& e) -> Outcome<Done> {
        const auto around_vertices = balls(mesh.linear, part_of(e, 0, 0.1));
        if (!around_vertices) return fail(around_vertices.error());
        const Buffer<double> longest = longest_edges(mesh);
        for (std::size_t f = 0; f < fields.size(); ++f) {
            const FieldDerivatives<D>& field = derivatives->fields[f];
            if (is_exact(derivatives->rows, longest, field, fields[f], options.norm.degree)) continue;
            auto of_field = models.of(field, *around_vertices, complexity, largest, without_progress(e));
            if (!of_field) return fail(of_field.error());
            out.zero_models += of_field->zero;
            out.floored_models += of_field->floored;
            const bool has_reason =
                std::ranges::any_of(of_field->rows, [](const auto& m) { return m.kind != ModelKind::zero; });
            if (has_reason) parts.push_back({std::move(of_field->rows), options.norm, 1});
        }
        if (options.expected.l2 == 0) return Done{};
        const auto weights = weights_of(options.expected, input_fields);
        const auto gradients = normal_gradients<D>(mesh, *around_vertices, *derivatives, weights, without_progress(e));
        if (!gradients) return fail(gradients.error());
        auto bounds =
            bounds_by_error<D>(mesh, options.expected.l2, range_of(fields, weights), *gradients, without_progress(e));
        if (!bounds) return fail(bounds.error());
        out.bounds = std::move(*bounds);
        return Done{};
    });
    if (!result) return fail(result.error());
    if (parts.empty() && derivatives->missing == out.rows)
        return fail(ErrorKind::input, "has too few nodes for derivatives of the solution", {}, {},
                    "give a mesh with several elements in each direction");
    if (parts.empty())
        return fail(ErrorKind::usage,
                    "the derivatives that determine the error are 0 everywhere: there is nothing to "
                    "adapt to",
                    "solution", {},
                    options.norm.degree == 2 ? "any mesh of degree 2 interpolates it exactly; give another field, or "
                                               "--degree 1"
                                             : "any mesh interpolates it exactly; give another field");
    for (SolutionField<D>& part : parts) part.share = 1.0 / static_cast<double>(parts.size());
    const auto fixed = run_step(around, "fixed", [&](const Execution& e) {
        return fixed_part(mesh, models.is_straight(), specified, options, largest, e);
    });
    if (!fixed) return fail(fixed.error());
    auto whole = run_step(around, "metric", [&](const Execution& e) {
        return make_solution_metric<D>(mesh.linear, mesh.edges, parts, *fixed, metric, e);
    });
    if (!whole) return fail(whole.error());
    out.metric = std::move(*whole);
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes<D>(                               \
        const LinearMesh<D>&, const Features<D>&, const GeometrySizes&, double, const Execution&);       \
    template Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes<D>(                               \
        const QuadraticMesh<D>&, const Features<D>&, const GeometrySizes&, double, const Execution&);    \
    template Outcome<MetricOfSolution<D>> metric_of_solution<D>(                                         \
        const QuadraticMesh<D>&, std::span<const Column<double>>, std::span<const Column<LogMetric<D>>>, \
        const MetricOfSolutionOptions&, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
