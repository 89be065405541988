module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.fields;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.solution_metric;
import camber.surface;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

template <int D>
SourcedMetric<D> sourced(Column<LogMetric<D>> logs, std::string source) {
    return {std::move(logs), MetricReport{.source = std::move(source), .gradations = {}}, {}};
}

template <int D>
Outcome<LogMetric<D>> constant_log_metric(const config::ConstantMetric& constant) {
    if (!constant.sizes.empty()) {
        if (constant.sizes.size() != 1 && constant.sizes.size() != D)
            return fail(ErrorKind::usage, "expected 1 or " + std::to_string(D) + " sizes", "/metric/constant/sizes");
        Vec<D> sizes;
        for (std::size_t i = 0; i < D; ++i) sizes[i] = constant.sizes[constant.sizes.size() == 1 ? 0 : i];
        return log_metric_of_sizes(sizes);
    }
    if (constant.tensor.size() != sym_size<D>)
        return fail(ErrorKind::usage, "expected " + std::to_string(sym_size<D>) + " numbers",
                    "/metric/constant/tensor");
    auto logs = log_metrics_of_tensors<D>(constant.tensor, TensorPrecision::eight_bytes, Execution{.threads = 1});
    if (!logs) return fail(ErrorKind::usage, logs.error().what, "/metric/constant/tensor");
    return logs->log_metrics.front();
}

}  // namespace

template <int D>
Outcome<SourcedMetric<D>> log_metrics_of_file(const MetricFile& file, std::size_t vertices,
                                              const Execution& execution) {
    const Solution& s = file.solution;
    const auto refuse = [&](const std::string& what, const std::string& remedy) {
        return fail(ErrorKind::input, what, file.name, {}, remedy);
    };
    if (s.dimension != D)
        return refuse("is in " + std::to_string(s.dimension) + "D, the mesh in " + std::to_string(D) + "D",
                      "give the metric of this mesh");
    if (s.rows != vertices)
        return refuse("has " + std::to_string(s.rows) + " rows, the mesh " + std::to_string(vertices) + " vertices",
                      "give the metric of this mesh, one row a vertex");
    if (s.fields == std::vector{FieldKind::scalar}) {
        // One size a vertex: an isotropic metric, as Mmg and refine read such a file.
        Buffer<LogMetric<D>> logs(vertices);
        for (std::size_t v = 0; v < vertices; ++v) {
            if (!(s.values[v] > 0) || !std::isfinite(s.values[v]))
                return fail(ErrorKind::input, "is not a positive size", file.name, Entity{"size at vertex", v + 1});
            logs[v] = {-2 * log(s.values[v]) * Sym<D>::identity()};
        }
        return sourced(Column<LogMetric<D>>(std::move(logs)), file.name);
    }
    if (s.fields != std::vector{FieldKind::symmetric_tensor})
        return refuse("is no metric: it must hold one symmetric tensor (type 3) or one size (type 1) a vertex", "");
    auto logs = log_metrics_of_tensors<D>(
        s.values.view(), s.single_precision ? TensorPrecision::four_bytes : TensorPrecision::eight_bytes, execution);
    if (!logs) {
        Error error = logs.error();
        error.where = file.name;
        return fail(std::move(error));
    }
    SourcedMetric<D> metric = sourced(Column<LogMetric<D>>(std::move(logs->log_metrics)), file.name);
    metric.report.floored = logs->floored;
    if (logs->floored > 0)
        metric.notices.push_back(
            fmt::format("{} of the {} tensors of {} are flat to the rounding of their numbers: the sizes of their flat "
                        "directions were "
                        "made smaller, to what that can tell",
                        logs->floored, vertices, file.name));
    return metric;
}

namespace {

/// A field that is given where the vertices were read, where they are now.
template <int D>
Outcome<Column<LogMetric<D>>> at_moved_vertices(Column<LogMetric<D>> field, const MetricInput<D>& input,
                                                const Execution& execution) {
    const Column<Vec<D>>& points = input.mesh.points;
    if (points == input.given_points) return field;
    LinearMesh<D> given = input.mesh;
    given.points = input.given_points;
    const auto around = balls(given, part_of(execution, 0, 0.2));
    if (!around) return fail(around.error());
    const auto back = make_back_mesh(given, *around, field, part_of(execution, 0.2, 0.7));
    if (!back) return fail(back.error());
    auto moved = map_each(part_of(execution, 0.7, 1), points.size(), [&](std::size_t v) {
        if (points[v] == given.points[v] || (*around)[v].empty()) return field[v];
        return sample_value(*back, points[v], (*around)[v].front()).log_metric;
    });
    if (!moved) return fail(moved.error());
    return Column<LogMetric<D>>(std::move(*moved));
}

/// One source of a field each; what a file holds is read already.
template <int D>
struct Source {
    const MetricInput<D>& input;
    const Execution& execution;

    Outcome<SourcedMetric<D>> operator()(const config::NaturalMetric&) const {
        return sourced(input.natural, "natural");
    }
    Outcome<SourcedMetric<D>> operator()(const config::ConstantMetric& constant) const {
        const auto value = constant_log_metric<D>(constant);
        if (!value) return fail(value.error());
        Buffer<LogMetric<D>> logs(input.mesh.points.size());
        std::fill(logs.begin(), logs.end(), *value);
        return sourced(Column<LogMetric<D>>(std::move(logs)), "constant");
    }
    Outcome<SourcedMetric<D>> operator()(const config::SurfaceMetric& surface) const {
        return made(make_surface_metric(surface, input, execution), "surface");
    }
    Outcome<SourcedMetric<D>> operator()(const config::FieldMetric& field) const {
        return made(make_field_metric(field, input.mesh, execution), "field");
    }
    Outcome<SourcedMetric<D>> operator()(const MetricExpression& expression) const {
        return made(log_metrics_of<D>(expression, input.mesh.points.view(), execution), "expression");
    }
    Outcome<SourcedMetric<D>> operator()(const config::SizesMetric& asked) const {
        auto sizes = sizes_by_reference(input.mesh, asked.sizes);
        if (!sizes) return fail(sizes.error());
        return made(within_domain({std::move(*sizes)}), "sizes");
    }
    Outcome<SourcedMetric<D>> operator()(const config::GeometryMetric& asked) const {
        auto sizes = geometry_sizes(input.mesh, input.boundary.features, asked, diameter(input.mesh),
                                    part_of(execution, 0, 0.8));
        if (!sizes) return fail(sizes.error());
        return made(within_domain(*sizes), "geometry");
    }
    Outcome<SourcedMetric<D>> operator()(const config::FilePath& path) const { return rows_of(path); }
    Outcome<SourcedMetric<D>> operator()(const config::SolutionMetric& solution) const { return rows_of(solution); }

  private:
    [[nodiscard]] Outcome<SourcedMetric<D>> rows_of(const config::Metric& asked) const {
        const auto file = std::ranges::find_if(input.files, [&](const MetricFile& f) { return f.is_of(asked); });
        if (file == input.files.end()) return fail(ErrorKind::internal, "the metric's rows were not read");
        if (file->mesh) return sampled_file<D>(*file, input.mesh.points, execution);
        auto metric = log_metrics_of_file<D>(*file, input.mesh.points.size(), part_of(execution, 0, 0.6));
        if (!metric) return metric;
        auto here = at_moved_vertices(std::move(metric->log_metrics), input, part_of(execution, 0.6, 1));
        if (!here) return fail(here.error());
        metric->log_metrics = std::move(*here);
        return metric;
    }
    /// Elsewhere as large as the domain.
    [[nodiscard]] Outcome<Column<LogMetric<D>>> within_domain(const std::vector<MetricsAtVertices<D>>& sizes) const {
        return fixed_metric<D>(input.mesh, sizes, {}, diameter(input.mesh), without_progress(execution));
    }
    static Outcome<SourcedMetric<D>> made(Outcome<Column<LogMetric<D>>> logs, const char* source) {
        if (!logs) return fail(logs.error());
        return sourced(std::move(*logs), source);
    }
};

}  // namespace

template <int D>
Outcome<SourcedMetric<D>> make_log_metrics(const MetricInput<D>& input, const config::Metric& metric,
                                           const Execution& execution) {
    auto made = std::visit(Source<D>{input, execution}, metric);
    if (!made || std::holds_alternative<config::NaturalMetric>(metric)) return made;
    if (auto sizes = check_sizes(made->log_metrics, without_progress(execution)); !sizes) {
        Error error = sizes.error();
        const auto* file = std::get_if<config::FilePath>(&metric);
        if (file) error.where = file->path;
        if (!file && error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return fail(std::move(error));
    }
    return made;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<SourcedMetric<D>> make_log_metrics<D>(const MetricInput<D>&, const config::Metric&, \
                                                           const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

template Outcome<SourcedMetric<2>> log_metrics_of_file<2>(const MetricFile&, std::size_t, const Execution&);
template Outcome<SourcedMetric<3>> log_metrics_of_file<3>(const MetricFile&, std::size_t, const Execution&);

}  // namespace camber::run
