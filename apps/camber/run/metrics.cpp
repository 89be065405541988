module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <ranges>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.fields;
import camber.metric;
import camber.surface;
import :stages;
import :state;

namespace camber::run {

namespace {

template <int D>
Outcome<Vec<D>> vec(const std::vector<double>& numbers, const char* what) {
    if (numbers.size() != D)
        return fail(ErrorKind::usage, std::string(what) + " has " + std::to_string(numbers.size()) +
                                          " coordinates, the mesh " + std::to_string(D));
    Vec<D> v;
    for (std::size_t i = 0; i < D; ++i) v[i] = numbers[i];
    return v;
}

/// A field as the config has it, with vectors of the mesh's dimension.
template <int D, class Field>
Outcome<AnalyticField<D>> of_dimension(const Field& field) {
    return AnalyticField<D>(field);
}
template <int D>
Outcome<AnalyticField<D>> of_dimension(const config::PlanarShock& s) {
    auto point = vec<D>(s.point, "the shock's point");
    if (!point) return fail(point.error());
    auto normal = vec<D>(s.normal, "the shock's normal");
    if (!normal) return fail(normal.error());
    return AnalyticField<D>(PlanarShock<D>{*point, *normal, s.min_size, s.size, s.width});
}
template <int D>
Outcome<AnalyticField<D>> of_dimension(const config::SphericalShock& s) {
    auto centre = vec<D>(s.centre, "the shock's centre");
    if (!centre) return fail(centre.error());
    return AnalyticField<D>(SphericalShock<D>{*centre, s.radius, s.min_size, s.size, s.width});
}

/// The geometry's unit normals at the corners of the facets; zero where a facet has no surface.
template <int D>
Outcome<Buffer<std::array<Vec<D>, D>>> normals_of(const Geometry<D>& geometry, const LinearMesh<D>& mesh,
                                                  const Execution& execution) {
    return map_each(execution, mesh.facets.size(), [&](std::size_t f) {
        return geometry->normals_at(facet_site(mesh, FacetId(f))).value_or(std::array<Vec<D>, D>{});
    });
}

/// The unit normal at each corner of each facet: of the surface that the facet lies on, else of a surrogate that is
/// made for its normals.
template <int D>
Outcome<Buffer<std::array<Vec<D>, D>>> corner_normals(const MetricInput<D>& input, const Execution& execution) {
    const LinearMesh<D>& mesh = input.mesh;
    const Geometry<D>& geometry = input.boundary.geometry;
    auto normals = normals_of(geometry, mesh, part_of(execution, 0, 0.2));
    if (!normals) return normals;
    const auto has_surface = [&](std::size_t f) { return geometry->has_surface_at(facet_site(mesh, FacetId(f))); };
    const auto facets = std::views::iota(std::size_t{0}, mesh.facets.size());
    if (std::ranges::all_of(facets, has_surface)) return normals;
    auto surrogate =
        build_surrogate(mesh, input.edges, input.boundary.features, SurrogateOptions{}, part_of(execution, 0.2, 0.8));
    if (!surrogate) return fail(surrogate.error());
    const auto made = normals_of(Geometry<D>(std::move(*surrogate)), mesh, part_of(execution, 0.8, 1));
    if (!made) return made;
    for (const std::size_t f : facets)
        if (!has_surface(f)) (*normals)[f] = (*made)[f];
    return normals;
}

/// The normals at each vertex, one a smooth side: those of its facets, without repetition.
template <int D>
Outcome<VertexNormals<D>> boundary_normals(const MetricInput<D>& input, const Execution& execution) {
    const auto normals = corner_normals(input, part_of(execution, 0, 0.8));
    if (!normals) return fail(normals.error());
    const auto around = facet_balls(input.mesh, part_of(execution, 0.8, 1));
    if (!around) return fail(around.error());
    const LinearMesh<D>& mesh = input.mesh;
    constexpr double same = 1 - 1e-8;  // cosine: facets of one side agree to rounding
    Buffer<std::uint32_t> offsets{0};
    Buffer<Vec<D>> items;
    offsets.reserve(mesh.points.size() + 1);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const std::size_t begin = items.size();
        for (const FacetId f : (*around)[v])
            for (std::size_t i = 0; i < D; ++i) {
                if (mesh.facets.vertices[f][i].index() != v) continue;
                const Vec<D>& n = (*normals)[f.index()][i];
                bool known = !(norm_squared(n) > 0);
                for (std::size_t k = begin; k < items.size(); ++k) known = known || std::abs(dot(items[k], n)) > same;
                if (!known) items.push_back(n);
            }
        offsets.push_back(static_cast<std::uint32_t>(items.size()));
    }
    return VertexNormals<D>{Column<std::uint32_t>(std::move(offsets)), Column<Vec<D>>(std::move(items))};
}

/// An operation's effect on a field; what the report says of it goes into the field's part.
template <int D>
struct Operation {
    SourcedMetric<D>& field;
    const MetricInput<D>& input;
    const Execution& execution;

    Outcome<Column<LogMetric<D>>> operator()(const config::Intersect& intersect) {
        auto other = make_log_metrics(input, intersect.metric, part_of(execution, 0, 0.5));
        if (!other) return fail(other.error());
        field.report.source += " and " + other->report.source;
        field.report.floored += other->report.floored;
        field.notices.insert(field.notices.end(), other->notices.begin(), other->notices.end());
        return intersection(field.log_metrics, other->log_metrics, part_of(execution, 0.5, 1));
    }
    Outcome<Column<LogMetric<D>>> operator()(const config::Gradation& gradation) {
        auto out = apply_gradation(input.mesh, input.edges, field.log_metrics, gradation, execution);
        if (!out) return fail(out.error());
        field.report.gradations.push_back({out->sweeps, out->changed, out->converged});
        if (!out->converged)
            field.notices.push_back("the gradation ended after " + std::to_string(out->sweeps) +
                                    " sweeps: somewhere sizes still grow faster than asked");
        return std::move(out->log_metrics);
    }
    Outcome<Column<LogMetric<D>>> operator()(const config::Bound& bound) {
        constexpr double none = std::numeric_limits<double>::infinity();
        return apply_bounds(field.log_metrics,
                            MetricBounds{.min_size = bound.min_size,
                                         .max_size = bound.max_size > 0 ? bound.max_size : none,
                                         .max_anisotropy = bound.max_anisotropy > 0 ? bound.max_anisotropy : none},
                            execution);
    }
    Outcome<Column<LogMetric<D>>> operator()(const config::Complexity& wanted) {
        return scale_to_complexity(input.mesh, field.log_metrics, wanted.target, execution);
    }
};

/// One operation. Those that set sizes may set them out of range.
template <int D>
Outcome<Column<LogMetric<D>>> after(SourcedMetric<D>& field, const MetricInput<D>& input,
                                    const config::MetricOperation& operation, const Execution& execution) {
    auto next = std::visit(Operation<D>{field, input, execution}, operation);
    const bool sets_sizes =
        std::holds_alternative<config::Bound>(operation) || std::holds_alternative<config::Complexity>(operation);
    if (!next || !sets_sizes) return next;
    if (auto sizes = check_sizes(*next, without_progress(execution)); !sizes) {
        Error error = sizes.error();
        if (error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return fail(std::move(error));
    }
    return next;
}

}  // namespace

template <int D>
Outcome<Column<LogMetric<D>>> make_surface_metric(const config::SurfaceMetric& metric, const MetricInput<D>& input,
                                                  const Execution& execution) {
    const auto normals = boundary_normals(input, part_of(execution, 0, 0.5));
    if (!normals) return fail(normals.error());
    SurfaceMetricOptions options{metric.tangent_size, metric.normal_size, {}};
    if (metric.volume_size > 0) options.volume_size = metric.volume_size;
    return surface_log_metrics<D>(*normals, options, part_of(execution, 0.5, 1));
}

template <int D>
Outcome<Column<LogMetric<D>>> make_field_metric(const config::FieldMetric& metric, const LinearMesh<D>& mesh,
                                                const Execution& execution) {
    auto field = std::visit([](const auto& f) { return of_dimension<D>(f); }, metric);
    if (!field) return fail(field.error());
    return log_metrics_of<D>(*field, mesh.points.view(), execution);
}

template <int D>
Outcome<SourcedMetric<D>> apply_operations(SourcedMetric<D> field, const MetricInput<D>& input,
                                           std::span<const config::MetricOperation> operations,
                                           const Execution& execution) {
    for (std::size_t i = 0; i < operations.size(); ++i) {
        const auto share = [n = static_cast<double>(operations.size())](std::size_t done) {
            return static_cast<double>(done) / n;
        };
        auto next = after(field, input, operations[i], part_of(execution, share(i), share(i + 1)));
        if (!next) {
            Error error = next.error();
            const std::string path = "/metric_operations/" + std::to_string(i);
            if (error.kind == ErrorKind::usage && error.where.empty()) error.where = path;
            if (error.where.starts_with("/metric/"))
                error.where = path + "/intersect/" + error.where.substr(std::string("/metric/").size());
            return fail(std::move(error));
        }
        field.log_metrics = std::move(*next);
    }
    return field;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Column<LogMetric<D>>> make_surface_metric<D>(const config::SurfaceMetric&, const MetricInput<D>&, \
                                                                  const Execution&);                                   \
    template Outcome<Column<LogMetric<D>>> make_field_metric<D>(const config::FieldMetric&, const LinearMesh<D>&,      \
                                                                const Execution&);                                     \
    template Outcome<SourcedMetric<D>> apply_operations<D>(                                                            \
        SourcedMetric<D>, const MetricInput<D>&, std::span<const config::MetricOperation>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
