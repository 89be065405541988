module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.io;
import camber.fields;
import camber.surface;
import camber.curving;
import camber.stages;

namespace camber::run {

namespace {

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

/// Zero: the facet has no surface.
template <int D>
Outcome<Buffer<std::array<Vec<D>, D>>> normals_of(const Geometry<D>& geometry, const LinearMesh<D>& mesh,
                                                  const Execution& execution) {
    return map_each(execution, mesh.facets.size(), [&](std::size_t f) {
        return geometry->normals_at(facet_site(mesh, FacetId(f))).value_or(std::array<Vec<D>, D>{});
    });
}

/// Normals of the facet's surface, else of a surrogate made for this.
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
    const auto result = normals_of(Geometry<D>(std::move(*surrogate)), mesh, part_of(execution, 0.8, 1));
    if (!result) return result;
    for (const std::size_t f : facets)
        if (!has_surface(f)) (*normals)[f] = (*result)[f];
    return normals;
}

/// Normals at each vertex: one for each smooth side, without repetition.
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
                                    " sweeps: some sizes still grow faster than requested");
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
    Outcome<Column<LogMetric<D>>> operator()(const config::Complexity& requested) {
        return scale_to_complexity(input.mesh, field.log_metrics, requested.target, execution);
    }
};

/// Operations that set sizes may set them out of range.
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

namespace {

/// Row in the file of each vertex and edge, from 1; 0: none. Empty if the file has another number of rows than nodes.
template <int D>
std::vector<std::uint32_t> rows_of_nodes(const Mesh<D>& mesh, const Column<std::uint32_t>& numbers, std::size_t rows) {
    const std::size_t nodes = count_nodes(mesh);
    std::vector<std::uint32_t> out(nodes);
    std::size_t most = 0;
    for (std::size_t n = 0; n < nodes; ++n) {
        out[n] = numbers.empty() ? static_cast<std::uint32_t>(n + 1) : numbers[n];
        most = std::max<std::size_t>(most, out[n]);
    }
    return most == rows && rows != mesh.points.size() ? out : std::vector<std::uint32_t>{};
}

template <int D>
RowsByNodes sorted(Solution solution, const Mesh<D>& mesh, const Column<std::uint32_t>& numbers) {
    if (mesh.degree == 1) return {std::move(solution), false};
    const std::vector<std::uint32_t> at = rows_of_nodes(mesh, numbers, solution.rows);
    if (at.empty()) return {std::move(solution), false};
    const std::size_t width = row_width(solution), vertices = mesh.points.size();
    Buffer<double> values(at.size() * width);
    const auto row = [&](std::size_t n) { return solution.values.data() + (at[n] - 1) * width; };
    for (std::size_t n = 0; n < at.size(); ++n) {
        if (at[n] > 0) {
            std::copy(row(n), row(n) + width, values.begin() + static_cast<std::ptrdiff_t>(n * width));
            continue;
        }
        if (n < vertices) return {std::move(solution), false};
        const auto& [a, b] = mesh.entities.edges[n - vertices];
        for (std::size_t c = 0; c < width; ++c) values[n * width + c] = 0.5 * (row(a.index())[c] + row(b.index())[c]);
    }
    solution.rows = at.size();
    solution.values = std::move(values);
    return {std::move(solution), true};
}

/// Vertices first, then edges.
template <int D>
NodalLogs<D> split(const Column<LogMetric<D>>& logs, std::size_t vertices) {
    const auto middle = logs.begin() + static_cast<std::ptrdiff_t>(vertices);
    return {Column<LogMetric<D>>(Buffer<LogMetric<D>>(logs.begin(), middle)),
            Column<LogMetric<D>>(Buffer<LogMetric<D>>(middle, logs.end()))};
}

template <int D>
Outcome<FileField<D>> field_on(const MetricFile& file, const QuadraticMesh<D>& mesh, const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    const bool at_nodes = file.solution.rows == vertices + mesh.edges.size();
    auto metric = log_metrics_of_file<D>(file, at_nodes ? file.solution.rows : vertices, part_of(execution, 0, 0.3));
    if (!metric) return fail(metric.error());
    if (auto sizes = check_sizes(metric->log_metrics, without_progress(execution)); !sizes) return fail(sizes.error());
    auto logs = at_nodes ? Outcome<NodalLogs<D>>(split<D>(metric->log_metrics, vertices))
                         : nodal_logs(mesh.edges, metric->log_metrics, without_progress(execution));
    if (!logs) return fail(logs.error());
    auto volume = complexity(mesh, *logs, part_of(execution, 0.3, 0.5));
    if (!volume) return fail(volume.error());
    auto largest = largest_anisotropy(metric->log_metrics, without_progress(execution));
    if (!largest) return fail(largest.error());
    const auto around = balls(mesh.linear, part_of(execution, 0.5, 0.6));
    if (!around) return fail(around.error());
    auto back = make_nodal_back_mesh(mesh, *around, std::move(*logs), part_of(execution, 0.6, 1));
    if (!back) return fail(back.error());
    metric->report.complexity = *volume;
    metric->report.largest_anisotropy = *largest;
    return FileField<D>{std::move(*back), std::move(metric->report), std::move(metric->notices)};
}

template <int D>
Outcome<FileField<D>> field_on(const MetricFile& file, const LinearMesh<D>& mesh, const Execution& execution) {
    auto metric = log_metrics_of_file<D>(file, mesh.points.size(), part_of(execution, 0, 0.3));
    if (!metric) return fail(metric.error());
    if (auto sizes = check_sizes(metric->log_metrics, without_progress(execution)); !sizes) return fail(sizes.error());
    auto volume = complexity(mesh, metric->log_metrics, part_of(execution, 0.3, 0.5));
    if (!volume) return fail(volume.error());
    auto largest = largest_anisotropy(metric->log_metrics, without_progress(execution));
    if (!largest) return fail(largest.error());
    const auto around = balls(mesh, part_of(execution, 0.5, 0.6));
    if (!around) return fail(around.error());
    auto back = make_back_mesh(mesh, *around, std::move(metric->log_metrics), part_of(execution, 0.6, 1));
    if (!back) return fail(back.error());
    metric->report.complexity = *volume;
    metric->report.largest_anisotropy = *largest;
    return FileField<D>{std::move(*back), std::move(metric->report), std::move(metric->notices)};
}

}  // namespace

Outcome<RowsByNodes> rows_by_nodes(Solution solution, const DecodedMesh& mesh, const Execution& execution) {
    if (execution.stop.stop_requested()) return stopped();
    return guarded([&]() -> Outcome<RowsByNodes> {
        return std::visit([&](const auto& m) { return sorted(std::move(solution), m, mesh.node_numbers); }, mesh.mesh);
    });
}

Solution rows_at_vertices(RowsByNodes rows, const AnyMesh& mesh) {
    Solution out = std::move(rows.solution);
    if (!rows.is_at_nodes) return out;
    out.rows = std::visit([](const auto& m) { return m.points.size(); }, mesh);
    const auto end = out.values.begin() + static_cast<std::ptrdiff_t>(out.rows * row_width(out));
    out.values = Buffer<double>(out.values.begin(), end);
    return out;
}

const MetricFile* file_with_mesh(const config::Pipeline& config, std::span<const MetricFile> files) {
    const auto file =
        std::ranges::find_if(files, [&](const MetricFile& f) { return f.is_of(config.metric) && f.mesh.has_value(); });
    return file == files.end() ? nullptr : &*file;
}

namespace {

template <int D>
Vec<D> place_of(const Location<D>& at, const LinearMesh<D>& mesh) {
    Vec<D> place;
    for (int i = 0; i <= D; ++i)
        place += at.xi[static_cast<std::size_t>(i)] *
                 mesh.points[mesh.elements.vertices[at.element.index()][static_cast<std::size_t>(i)]];
    return place;
}
template <int D>
Vec<D> place_of(const Location<D>& at, const QuadraticMesh<D>& mesh) {
    const auto& v = mesh.linear.elements.vertices[at.element.index()];
    Vec<D> place;
    for (std::size_t i = 0; i <= D; ++i) place += at.xi[i] * (2 * at.xi[i] - 1) * mesh.linear.points[v[i]];
    for (std::size_t k = 0; k < static_cast<std::size_t>(edges_per_simplex<D>); ++k) {
        const auto& [i, j] = local_edges<D>[k];
        place += 4 * at.xi[static_cast<std::size_t>(i)] * at.xi[static_cast<std::size_t>(j)] *
                 mesh.mid_nodes[mesh.edges.of_elements[at.element.index()][k]].point;
    }
    return place;
}

struct Outside {
    std::size_t points = 0;
    double farthest = 0;
    std::size_t first = 0;  ///< number of the farthest point, from 1
};
Outside joined(const Outside& a, const Outside& b) {
    const Outside& farther = b.farthest > a.farthest ? b : a;
    return {a.points + b.points, farther.farthest, farther.first};
}

/// Points outside the mesh of a metric take the values of its nearest point. This suits walls that differ slightly. A
/// mesh in another place or unit would get a meaningless metric, so it is rejected.
template <int D, class Mesh>
Outcome<Done> check_place(const MetricFile& file, const Mesh& mesh, const Column<Vec<D>>& input_points,
                          FileField<D>& field, const Execution& execution) {
    constexpr double refused = 0.1, noted = 1e-3;  // relative to the mesh's size
    Box<D> box;
    for (const Vec<D>& p : input_points) box.include(p);
    const double size = box.diagonal();
    const auto outside = reduce_each(
        execution, input_points.size(), Outside{},
        [&](Outside& all, std::size_t v) {
            const FieldSample<D> sample = sample_value(field.back, input_points[v], ElementId(0));
            if (sample.location.placement == Placement::inside) return;
            all = joined(all, {1, distance(input_points[v], place_of(sample.location, mesh)), v + 1});
        },
        joined, 512);
    if (!outside) return fail(outside.error());
    if (outside->farthest > refused * size)
        return fail(
            ErrorKind::input,
            fmt::format("is in another place than the mesh: {} of its {} vertices are outside, by up to {:.4g}; the "
                        "size of the mesh is {:.4g}",
                        outside->points, input_points.size(), outside->farthest, size),
            "/metric_mesh", {},
            "give the mesh of " + file.name + " in the mesh's place and unit, or a metric of this mesh");
    if (outside->farthest > noted * size)
        field.notices.push_back(
            fmt::format("{} vertices are outside the metric's mesh, by up to {:.4g}; they have the metric of its "
                        "nearest points",
                        outside->points, outside->farthest));
    return Done{};
}

}  // namespace

template <int D>
Outcome<FileField<D>> field_of_file(const MetricFile& file, const Column<Vec<D>>& input_points,
                                    const Execution& execution) {
    return std::visit(
        [&]<int Own>(const Mesh<Own>& mesh) -> Outcome<FileField<D>> {
            if constexpr (Own == D)
                return on_simplices(mesh, [&](const auto& of) {
                    return guarded([&]() -> Outcome<FileField<D>> {
                        auto field = field_on(file, of, part_of(execution, 0, 0.9));
                        if (!field || file.mesh->of == MetricMesh::Of::input) return field;
                        return check_place(file, of, input_points, *field, part_of(execution, 0.9, 1)).map([&](Done) {
                            return std::move(*field);
                        });
                    });
                });
            else
                return fail(ErrorKind::input,
                            "is in " + std::to_string(Own) + "D, the mesh in " + std::to_string(D) + "D",
                            "/metric_mesh", {}, "give the mesh of the metric");
        },
        file.mesh->mesh);
}

template <int D>
Outcome<SourcedMetric<D>> sampled_file(const MetricFile& file, const Column<Vec<D>>& points,
                                       const Execution& execution) {
    const auto field = field_of_file<D>(file, points, part_of(execution, 0, 0.5));
    if (!field) return fail(field.error());
    const auto point_at = [&](std::size_t v) { return points[v]; };
    auto logs = sampled_logs(field->back, points.size(), point_at, part_of(execution, 0.5, 1));
    if (!logs) return fail(logs.error());
    return SourcedMetric<D>{std::move(*logs), field->report, field->notices};
}

namespace {

/// Operations are already applied.
template <int D>
SourcedMetric<D> inherited_metric(const Inherited<D>& inherited) {
    return {inherited.log_metrics,
            MetricReport{.source = inherited.metric.source, .gradations = inherited.metric.gradations},
            {}};
}

template <int D>
Outcome<SourcedMetric<D>> log_metrics_of(const MetricInput<D>& input, const config::Pipeline& config,
                                         const Execution& execution) {
    if (input.inherited) return inherited_metric(*input.inherited);
    auto result = make_log_metrics(input, config.metric, part_of(execution, 0, 0.3));
    if (result)
        return apply_operations(std::move(*result), input, config.metric_operations, part_of(execution, 0.3, 1));
    Error& error = result.error();
    if (error.kind == ErrorKind::usage && error.where.empty()) error.where = "/metric";
    return result;
}

template <int D>
Outcome<SourcedMetric<D>> with_extent(const LinearMesh<D>& mesh, SourcedMetric<D> metric, const Execution& execution) {
    const auto volume = complexity(mesh, metric.log_metrics, part_of(execution, 0, 0.7));
    if (!volume) return fail(volume.error());
    metric.report.complexity = *volume;
    const auto largest = largest_anisotropy(metric.log_metrics, part_of(execution, 0.7, 1));
    if (!largest) return fail(largest.error());
    metric.report.largest_anisotropy = *largest;
    return metric;
}

template <int D>
Outcome<SourcedMetric<D>> field_of(const MetricInput<D>& input, const config::Pipeline& config,
                                   const Execution& execution) {
    auto result = log_metrics_of(input, config, part_of(execution, 0, 0.5));
    if (!result) return result;
    return with_extent(input.mesh, std::move(*result), part_of(execution, 0.5, 1));
}

/// True if the config uses the mesh-implied metric, which differs on a curved mesh.
template <int D>
bool uses_natural_metric(const MetricInput<D>& input, const config::Pipeline& config) {
    if (input.inherited) return false;
    const auto is_natural = [](const config::Metric& m) { return std::holds_alternative<config::NaturalMetric>(m); };
    return is_natural(config.metric) ||
           std::ranges::any_of(config.metric_operations, [&](const config::MetricOperation& operation) {
               const auto* intersect = std::get_if<config::Intersect>(&operation);
               return intersect != nullptr && is_natural(intersect->metric);
           });
}

/// Metric file to sample on its own mesh, not at the vertices first; null if operations change the metric.
template <int D>
const MetricFile* whole_field(const Runner<D>& run) {
    if (run.state.inherited || !run.config.metric_operations.empty()) return nullptr;
    return file_with_mesh(run.config, run.files);
}

template <int D>
MetricSource<D> field_of_whole(const MetricFile& file, const Column<Vec<D>>& input_points,
                               MetricReports& metric_report) {
    return MetricField<D>{[&file, input_points, &metric_report](const Execution& e) -> Outcome<BackMesh<D>> {
        auto field = field_of_file<D>(file, input_points, e);
        if (!field) return fail(field.error());
        metric_report = {std::move(field->report), std::move(field->notices)};
        return std::move(field->back);
    }};
}

/// Reports the metric only once: a second call is for the same mesh with straight edges.
template <int D>
MetricSource<D> at_vertices(const Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                            const Boundary<D>& boundary, MetricReports& metric_report) {
    const MetricInput<D> input{mesh,
                               edges,
                               boundary,
                               run.state.input_points,
                               run.files,
                               {},
                               run.state.inherited ? &*run.state.inherited : nullptr};
    const config::Pipeline& config = run.config;
    return MetricAtVertices<D>{
        uses_natural_metric(input, config),
        [input, &config, &metric_report](const Column<LogMetric<D>>& natural,
                                         const Execution& e) -> Outcome<Column<LogMetric<D>>> {
            MetricInput<D> with_natural = input;
            with_natural.natural = natural;
            if (metric_report.report)
                return log_metrics_of(with_natural, config, e).map(&SourcedMetric<D>::log_metrics);
            auto field = field_of(with_natural, config, e);
            if (!field) return fail(field.error());
            metric_report = {std::move(field->report), std::move(field->notices)};
            return std::move(field->log_metrics);
        }};
}

template <int D>
MetricSource<D> metric_of_goal(const MetricSource<D>& metric, const LinearMesh<D>& mesh, MetricReports& metric_report) {
    MetricReport report;
    report.source = origin_of(metric) == MetricOrigin::natural ? "natural" : "values";
    const auto* const specified = std::get_if<MetricAtVertices<D>>(&metric);
    if (specified == nullptr) {
        metric_report.report = report;
        return metric;
    }
    return MetricAtVertices<D>{
        specified->of_natural,
        [make = specified->make, report, &mesh, &metric_report](const Column<LogMetric<D>>& natural,
                                                                const Execution& e) -> Outcome<Column<LogMetric<D>>> {
            auto logs = make(natural, part_of(e, 0, 0.5));
            if (!logs || metric_report.report) return logs;
            auto result = with_extent(mesh, SourcedMetric<D>{std::move(*logs), report, {}}, part_of(e, 0.5, 1));
            if (!result) return fail(result.error());
            metric_report.report = std::move(result->report);
            return std::move(result->log_metrics);
        }};
}

template <int D>
MetricSource<D> metric_for_passes(const Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                  const Boundary<D>& boundary, MetricReports& metric_report) {
    if (run.sources.goal != nullptr && !run.state.inherited)
        return metric_of_goal(run.sources.goal->metric, mesh, metric_report);
    const MetricFile* const file = whole_field(run);
    return file ? field_of_whole<D>(*file, mesh.points, metric_report)
                : at_vertices(run, mesh, edges, boundary, metric_report);
}

template <int D>
Outcome<OwnField<D>> own_field(Runner<D>& run, const auto& mesh, const MetricSource<D>& source,
                               MetricReports& metric_report) {
    auto result = run.step("metric", [&](const Execution& e) { return make_field(mesh, source, e); });
    if (!result) return fail(result.error());
    MetricReport report = *metric_report.report;
    report_metric(run, std::move(metric_report));
    return OwnField<D>{std::move(*result), std::move(report), origin_of(source)};
}

}  // namespace

template <int D>
void report_metric(Runner<D>& run, MetricReports metric_report) {
    if (metric_report.report) run.report.metric = std::move(metric_report.report);
    for (std::string& notice : metric_report.notices) run.note(std::move(notice));
}

template <int D>
MetricSource<D> metric_for_curving(const Runner<D>& run, const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                   MetricReports& metric_report) {
    if (run.sources.goal != nullptr && !run.state.inherited)
        return metric_of_goal(run.sources.goal->metric, mesh.linear, metric_report);
    // Search hints are elements of this mesh, so a field on another mesh is read at the vertices.
    const MetricFile* const file = whole_field(run);
    const bool is_of_input = file && file->mesh->of == MetricMesh::Of::input;
    return is_of_input ? field_of_whole<D>(*file, mesh.linear.points, metric_report)
                       : at_vertices(run, mesh.linear, mesh.edges, boundary, metric_report);
}

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                    const Boundary<D>& boundary) {
    MetricReports metric_report;
    return own_field<D>(run, mesh, metric_for_passes(run, mesh, edges, boundary, metric_report), metric_report);
}

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh, const Boundary<D>& boundary) {
    MetricReports metric_report;
    return own_field<D>(run, mesh, metric_for_passes(run, mesh.linear, mesh.edges, boundary, metric_report),
                        metric_report);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Column<LogMetric<D>>> make_surface_metric<D>(const config::SurfaceMetric&, const MetricInput<D>&, \
                                                                  const Execution&);                                   \
    template Outcome<Column<LogMetric<D>>> make_field_metric<D>(const config::FieldMetric&, const LinearMesh<D>&,      \
                                                                const Execution&);                                     \
    template Outcome<SourcedMetric<D>> apply_operations<D>(                                                            \
        SourcedMetric<D>, const MetricInput<D>&, std::span<const config::MetricOperation>, const Execution&);          \
    template Outcome<FileField<D>> field_of_file<D>(const MetricFile&, const Column<Vec<D>>&, const Execution&);       \
    template Outcome<SourcedMetric<D>> sampled_file<D>(const MetricFile&, const Column<Vec<D>>&, const Execution&);    \
    template void report_metric<D>(Runner<D>&, MetricReports);                                                         \
    template MetricSource<D> metric_for_curving<D>(const Runner<D>&, const QuadraticMesh<D>&, const Boundary<D>&,      \
                                                   MetricReports&);                                                    \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const LinearMesh<D>&, const EdgeSet<D>&,               \
                                                    const Boundary<D>&);                                               \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const QuadraticMesh<D>&, const Boundary<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
