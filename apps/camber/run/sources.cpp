module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.fields;
import camber.io;
import camber.metric;
import camber.surface;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
    using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

template <int D>
Outcome<Vec<D>> vec(const std::vector<double>& numbers, const char* what) {
    if (numbers.size() != D)
        return fail(ErrorKind::usage,
                    std::string(what) + " has " + std::to_string(numbers.size()) + " coordinates, the mesh " +
                        std::to_string(D),
                    "/geometry/analytic");
    Vec<D> v;
    for (int i = 0; i < D; ++i) v[i] = numbers[static_cast<std::size_t>(i)];
    return v;
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Plane& plane) {
    auto point = vec<D>(plane.point, "the plane's point");
    if (!point) return fail(point.error());
    auto normal = vec<D>(plane.normal, "the plane's normal");
    if (!normal) return fail(normal.error());
    return Plane<D>{*point, *normal};
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Sphere& sphere) {
    // Without a centre: the origin, in either dimension.
    auto centre = vec<D>(sphere.centre.empty() ? std::vector<double>(D, 0.0) : sphere.centre, "the sphere's centre");
    if (!centre) return fail(centre.error());
    return Sphere<D>{*centre, sphere.radius};
}

template <int D, class Solid, class Make>
Outcome<AnalyticSurface<D>> make_solid(const std::vector<double>& point, const std::vector<double>& axis,
                                       const char* name, Make make) {
    if constexpr (D == 2) {
        return fail(ErrorKind::usage, std::string("a ") + name + " is a surface in 3D, the mesh is in 2D",
                    "/geometry/analytic", {}, "a circle is a \"sphere\" in 2D");
    } else {
        auto p = vec<3>(point, "the point or centre");
        if (!p) return fail(p.error());
        auto a = vec<3>(axis, "the axis");
        if (!a) return fail(a.error());
        return make(*p, *a);
    }
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Cylinder& cylinder) {
    return make_solid<D, Cylinder>(cylinder.point, cylinder.axis, "cylinder",
                                   [&](const Vec<3>& p, const Vec<3>& a) { return Cylinder{p, a, cylinder.radius}; });
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Torus& torus) {
    return make_solid<D, Torus>(torus.centre, torus.axis, "torus", [&](const Vec<3>& p, const Vec<3>& a) {
        return Torus{p, a, torus.major_radius, torus.minor_radius};
    });
}

template <int D>
Outcome<AnalyticGeometry<D>> make_analytic(const config::Analytic& analytic) {
    AnalyticGeometry<D> geometry;
    for (const config::AnalyticSurface& entry : analytic.surfaces) {
        auto surface = std::visit([](const auto& s) { return make_surface<D>(s); }, entry.surface);
        if (!surface) return fail(surface.error());
        for (const Reference reference : entry.references) geometry.surfaces.emplace_back(reference, *surface);
    }
    return geometry;
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

template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_of_file(const MetricFile& file, std::size_t vertices, Report& report,
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
            logs[v] = {-2 * std::log(s.values[v]) * Sym<D>::identity()};
        }
        return Column<LogMetric<D>>(std::move(logs));
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
    report.metric->floored = logs->floored;
    return Column<LogMetric<D>>(std::move(logs->log_metrics));
}

/// A field that is given where the vertices were read, where they are now.
template <int D>
Outcome<Column<LogMetric<D>>> at_moved_vertices(Column<LogMetric<D>> field, const State<D>& state,
                                                const Execution& execution) {
    const Column<Vec<D>>& points = state.linear().points;
    if (points == state.given_points) return field;
    LinearMesh<D> given = state.linear();
    given.points = state.given_points;
    const auto around = balls(given, execution);
    if (!around) return fail(around.error());
    const auto back = make_back_mesh(given, *around, field, execution);
    if (!back) return fail(back.error());
    auto moved = map_each(execution, points.size(), [&](std::size_t v) {
        if (points[v] == given.points[v] || (*around)[v].empty()) return field[v];
        return sample_value(*back, points[v], (*around)[v].front()).log_metric;
    });
    if (!moved) return fail(moved.error());
    return Column<LogMetric<D>>(std::move(*moved));
}

template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_given(const config::Metric& metric, const std::optional<MetricFile>& file,
                                                const State<D>& state, Report& report, const Execution& execution) {
    if (const auto* constant = std::get_if<config::ConstantMetric>(&metric)) {
        report.metric->source = "constant";
        auto value = constant_log_metric<D>(*constant);
        if (!value) return fail(value.error());
        Buffer<LogMetric<D>> logs(state.linear().points.size());
        std::fill(logs.begin(), logs.end(), *value);
        return Column<LogMetric<D>>(std::move(logs));
    }
    if (const auto* surface = std::get_if<config::SurfaceMetric>(&metric)) {
        report.metric->source = "surface";
        return make_surface_metric(*surface, state, execution);
    }
    if (const auto* field = std::get_if<config::FieldMetric>(&metric)) {
        report.metric->source = "field";
        return make_field_metric(*field, state.linear(), execution);
    }
    if (const auto* expression = std::get_if<MetricExpression>(&metric)) {
        report.metric->source = "expression";
        return log_metrics_of<D>(*expression, state.linear().points.view(), execution);
    }
    if (!file) return fail(ErrorKind::internal, "the metric file was not read");
    report.metric->source = file->name;
    auto logs = log_metrics_of_file<D>(*file, state.linear().points.size(), report, execution);
    if (!logs) return logs;
    return at_moved_vertices(std::move(*logs), state, execution);
}

}  // namespace

template <int D>
Outcome<Geometry<D>> make_geometry(const config::Geometry& geometry, const State<D>& state,
                                   const Execution& execution) {
    if (std::holds_alternative<config::Straight>(geometry)) return Geometry<D>(StraightGeometry<D>{});
    if (const auto* analytic = std::get_if<config::Analytic>(&geometry)) {
        auto made = make_analytic<D>(*analytic);
        if (!made) return fail(made.error());
        if (auto fits = check_fit(state.linear(), *made, execution); !fits) {
            Error error = fits.error();
            if (error.kind == ErrorKind::usage) error.where = "/geometry/analytic";
            return fail(std::move(error));
        }
        return with_surrogate(std::move(*made), state.linear(), state.quadratic()->edges, *state.features,
                              SurrogateOptions{}, execution);
    }
    auto surrogate =
        build_surrogate(state.linear(), state.quadratic()->edges, *state.features, SurrogateOptions{}, execution);
    if (!surrogate) return fail(surrogate.error());
    return Geometry<D>(std::move(*surrogate));
}

template <int D>
Outcome<Column<LogMetric<D>>> make_log_metrics(const config::Metric& metric, const std::optional<MetricFile>& file,
                                               const State<D>& state, Report& report, const Execution& execution) {
    if (std::holds_alternative<config::NaturalMetric>(metric)) {
        report.metric->source = "natural";
        auto around = balls(state.linear(), execution);
        if (!around) return fail(around.error());
        auto logs = natural_log_metrics(state.linear(), *around, execution);
        if (!logs) return fail(logs.error());
        return Column<LogMetric<D>>(std::move(*logs));
    }
    auto given = log_metrics_given(metric, file, state, report, execution);
    if (!given) return given;
    if (auto sizes = check_sizes(*given, execution); !sizes) {
        Error error = sizes.error();
        const bool of_file = std::holds_alternative<config::FilePath>(metric);
        if (of_file && file) error.where = file->name;
        if (!of_file && error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return fail(std::move(error));
    }
    return given;
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<Geometry<D>> make_geometry<D>(const config::Geometry&, const State<D>&, const Execution&); \
    template Outcome<Column<LogMetric<D>>> make_log_metrics<D>(                                                 \
        const config::Metric&, const std::optional<MetricFile>&, const State<D>&, Report&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
