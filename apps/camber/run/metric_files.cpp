module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
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
import :report;
import :stages;

namespace camber::run {

namespace {

/// Of the mesh's vertices and edges: their rows in the file, from 1; 0: none. Empty where there is another number of
/// rows than the file has nodes.
template <int D>
std::vector<std::uint32_t> rows_of_nodes(const QuadraticMesh<D>& mesh, const Column<std::uint32_t>& numbers,
                                         std::size_t rows) {
    const std::size_t nodes = mesh.linear.points.size() + mesh.edges.size();
    std::vector<std::uint32_t> out(nodes);
    std::size_t most = 0;
    for (std::size_t n = 0; n < nodes; ++n) {
        out[n] = numbers.empty() ? static_cast<std::uint32_t>(n + 1) : numbers[n];
        most = std::max<std::size_t>(most, out[n]);
    }
    return most == rows && rows != mesh.linear.points.size() ? out : std::vector<std::uint32_t>{};
}

template <int D>
RowsByNodes sorted(Solution solution, const QuadraticMesh<D>& mesh, const Column<std::uint32_t>& numbers) {
    const std::vector<std::uint32_t> at = rows_of_nodes(mesh, numbers, solution.rows);
    if (at.empty()) return {std::move(solution), false};
    const std::size_t width = row_width(solution), vertices = mesh.linear.points.size();
    Buffer<double> values(at.size() * width);
    const auto row = [&](std::size_t n) { return solution.values.data() + (at[n] - 1) * width; };
    for (std::size_t n = 0; n < at.size(); ++n) {
        if (at[n] > 0) {
            std::copy(row(n), row(n) + width, values.begin() + static_cast<std::ptrdiff_t>(n * width));
            continue;
        }
        if (n < vertices) return {std::move(solution), false};
        const auto& [a, b] = mesh.edges.vertices[n - vertices];
        for (std::size_t c = 0; c < width; ++c) values[n * width + c] = 0.5 * (row(a.index())[c] + row(b.index())[c]);
    }
    solution.rows = at.size();
    solution.values = std::move(values);
    return {std::move(solution), true};
}
template <int D>
RowsByNodes sorted(Solution solution, const LinearMesh<D>&, const Column<std::uint32_t>&) {
    return {std::move(solution), false};
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
    out.rows = std::visit(
        [](const auto& m) {
            if constexpr (requires { m.linear; })
                return m.linear.points.size();
            else
                return m.points.size();
        },
        mesh);
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

/// Points that are outside the mesh of a metric, and how far one is.
struct Outside {
    std::size_t points = 0;
    double farthest = 0;
    std::size_t first = 0;  ///< the farthest
};
Outside joined(const Outside& a, const Outside& b) {
    const Outside& farther = b.farthest > a.farthest ? b : a;
    return {a.points + b.points, farther.farthest, farther.first};
}

/// A metric takes the values of the nearest point for what is outside of its mesh. That is meant for walls that are
/// not quite the same; a mesh in another place, or another unit, gets a metric that has nothing to do with it.
template <int D, class Mesh>
Outcome<Done> check_place(const MetricFile& file, const Mesh& mesh, const Column<Vec<D>>& asked, FileField<D>& field,
                          const Execution& execution) {
    constexpr double refused = 0.1, told = 1e-3;  // of the mesh's size
    Box<D> box;
    for (const Vec<D>& p : asked) box.include(p);
    const double size = box.diagonal();
    const auto outside = reduce_each(
        execution, asked.size(), Outside{},
        [&](Outside& all, std::size_t v) {
            const FieldSample<D> sample = sample_value(field.back, asked[v], ElementId(0));
            if (sample.location.placement == Placement::inside) return;
            all = joined(all, {1, distance(asked[v], place_of(sample.location, mesh)), v + 1});
        },
        joined, 512);
    if (!outside) return fail(outside.error());
    if (outside->farthest > refused * size)
        return fail(
            ErrorKind::input,
            fmt::format("is in another place than the mesh: {} of its {} vertices are outside, by up to {:.4g}, "
                        "and it is {:.4g} large",
                        outside->points, asked.size(), outside->farthest, size),
            "/metric_mesh", {},
            "give the mesh of " + file.name + " in the mesh's place and unit, or the metric of this mesh");
    if (outside->farthest > told * size)
        field.notices.push_back(
            fmt::format("{} vertices are outside the metric's mesh, by up to {:.4g}: they have the metric of its "
                        "nearest points",
                        outside->points, outside->farthest));
    return Done{};
}

}  // namespace

template <int D>
Outcome<FileField<D>> field_of_file(const MetricFile& file, const Column<Vec<D>>& asked, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh& mesh) -> Outcome<FileField<D>> {
            if constexpr (Mesh::dimension == D)
                return guarded([&]() -> Outcome<FileField<D>> {
                    auto field = field_on(file, mesh, part_of(execution, 0, 0.9));
                    if (!field || file.mesh->of == MetricMesh::Of::input) return field;
                    return check_place(file, mesh, asked, *field, part_of(execution, 0.9, 1)).map([&](Done) {
                        return std::move(*field);
                    });
                });
            else
                return fail(ErrorKind::input,
                            "is in " + std::to_string(Mesh::dimension) + "D, the mesh in " + std::to_string(D) + "D",
                            "/metric_mesh", {}, "give the mesh of the metric");
        },
        file.mesh->mesh);
}

template <int D>
Outcome<SourcedMetric<D>> sampled_file(const MetricFile& file, const Column<Vec<D>>& points,
                                       const Execution& execution) {
    const auto field = field_of_file<D>(file, points, part_of(execution, 0, 0.5));
    if (!field) return fail(field.error());
    return guarded([&]() -> Outcome<SourcedMetric<D>> {
        Buffer<LogMetric<D>> logs(points.size());
        auto done = each_chunk(part_of(execution, 0.5, 1), points.size(), [&](std::size_t begin, std::size_t end) {
            ElementId hint;
            for (std::size_t v = begin; v < end; ++v) {
                const FieldSample<D> sample = sample_value(field->back, points[v], hint);
                hint = sample.location.element;
                logs[v] = sample.log_metric;
            }
        });
        if (!done) return fail(done.error());
        return SourcedMetric<D>{Column<LogMetric<D>>(std::move(logs)), field->report, field->notices};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<FileField<D>> field_of_file<D>(const MetricFile&, const Column<Vec<D>>&, const Execution&); \
    template Outcome<SourcedMetric<D>> sampled_file<D>(const MetricFile&, const Column<Vec<D>>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
