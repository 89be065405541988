module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <variant>
module camber.fields;
import camber.core;
import camber.metric;

namespace camber {

namespace {

template <int D>
LogMetric<D> two_sizes(const Vec<D>& direction, double along, double across) {
    const double base = -2 * log(across);
    const double difference = -2 * log(along) - base;
    LogMetric<D> out{base * Sym<D>::identity()};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) out.l(i, j) += difference * direction[i] * direction[j];
    return out;
}

template <int D>
Vec<D> first_axis() {
    Vec<D> x;
    x[0] = 1;
    return x;
}

template <int D>
struct Polar {
    double r = 0;
    Vec<D> radial, tangential;
};
template <int D>
Polar<D> polar(const Vec<D>& x) {
    Polar<D> p;
    p.r = hypot(x[0], x[1]);
    p.radial[0] = p.r > 0 ? x[0] / p.r : 1;
    p.radial[1] = p.r > 0 ? x[1] / p.r : 0;
    p.tangential[0] = -p.radial[1];
    p.tangential[1] = p.radial[0];
    return p;
}

double layer_size(double least, double far, double distance_to_layer) {
    return least + 2 * (far - least) * distance_to_layer;
}

double shock_size(double least, double far, double s, double width) {
    const double u = tanh(s / width);
    return far * pow(least / far, 1 - u * u);
}

template <int D>
LogMetric<D> at(const LinearField& f, const Vec<D>& x) {
    Vec<D> sizes;
    for (double& h : sizes.c) h = f.scale * f.size;
    sizes[D - 1] = f.scale * layer_size(f.min_size, f.size, std::abs(x[D - 1] - f.position));
    return log_metric_of_sizes(sizes);
}
template <int D>
LogMetric<D> at(const PolarOneField& f, const Vec<D>& x) {
    const Polar<D> p = polar(x);
    return two_sizes(p.radial, f.scale * layer_size(f.min_size, f.size, std::abs(p.r - f.radius)), f.scale * f.size);
}
template <int D>
LogMetric<D> at(const PolarTwoField& f, const Vec<D>& x) {
    const Polar<D> p = polar(x);
    const double distance_to_layer = std::abs(p.r - f.radius);
    const double d = std::min(distance_to_layer / f.layer_width, 1.0);
    Mat<D> axes = Mat<D>::identity();
    axes.column[0] = p.radial;
    axes.column[1] = p.tangential;
    Vec<D> sizes;
    for (double& h : sizes.c) h = f.scale * f.size;
    sizes[0] = f.scale * layer_size(f.min_size, f.size, distance_to_layer);
    sizes[1] = f.scale * (f.size * d + f.tangential_size * (1 - d));
    return log_metric_of_sizes(sizes, axes);
}
template <int D>
LogMetric<D> at(const PlanarShock<D>& f, const Vec<D>& x) {
    const Vec<D> n = normalised(f.normal);
    return two_sizes(n, shock_size(f.min_size, f.size, dot(n, x - f.point), f.width), f.size);
}
template <int D>
LogMetric<D> at(const SphericalShock<D>& f, const Vec<D>& x) {
    const Vec<D> offset = x - f.centre;
    const double r = norm(offset);
    const Vec<D> n = r > 0 ? offset / r : first_axis<D>();
    return two_sizes(n, shock_size(f.min_size, f.size, r - f.radius, f.width), f.size);
}
template <int D>
LogMetric<D> at(const RotatingField& f, const Vec<D>& x) {
    const double angle = 2 * std::numbers::pi * x[0] / f.period;
    Vec<D> n;
    n[0] = cos(angle);
    n[1] = sin(angle);
    return two_sizes(n, f.min_size, f.size);
}

using Named = std::pair<const char*, double>;
std::string positive(std::initializer_list<Named> values) {
    for (const auto& [name, value] : values)
        if (!(value > 0) || !std::isfinite(value)) return std::string(name) + " must be positive";
    return {};
}

std::string check(const LinearField& f) {
    return positive({{"min_size", f.min_size}, {"size", f.size}, {"scale", f.scale}});
}
std::string check(const PolarOneField& f) {
    return positive({{"min_size", f.min_size}, {"size", f.size}, {"radius", f.radius}, {"scale", f.scale}});
}
std::string check(const PolarTwoField& f) {
    return positive({{"min_size", f.min_size},
                     {"tangential_size", f.tangential_size},
                     {"size", f.size},
                     {"radius", f.radius},
                     {"layer_width", f.layer_width},
                     {"scale", f.scale}});
}
template <int D>
std::string check(const PlanarShock<D>& f) {
    if (!(norm(f.normal) > 0) || !is_finite(f.normal)) return "the shock's normal is zero";
    return positive({{"min_size", f.min_size}, {"size", f.size}, {"width", f.width}});
}
template <int D>
std::string check(const SphericalShock<D>& f) {
    return positive({{"radius", f.radius}, {"min_size", f.min_size}, {"size", f.size}, {"width", f.width}});
}
std::string check(const RotatingField& f) {
    return positive({{"min_size", f.min_size}, {"size", f.size}, {"period", f.period}});
}

}  // namespace

template <int D>
LogMetric<D> evaluate(const AnalyticField<D>& field, const Vec<D>& x) {
    return std::visit([&](const auto& f) { return at<D>(f, x); }, field);
}

template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_of(const AnalyticField<D>& field, std::span<const Vec<D>> points,
                                             const Execution& execution) {
    if (std::string wrong = std::visit([](const auto& f) { return check(f); }, field); !wrong.empty())
        return fail(ErrorKind::usage, std::move(wrong));
    auto logs = map_each(execution, points.size(), [&](std::size_t v) { return evaluate<D>(field, points[v]); });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template LogMetric<D> evaluate<D>(const AnalyticField<D>&, const Vec<D>&);                                 \
    template Outcome<Column<LogMetric<D>>> log_metrics_of<D>(const AnalyticField<D>&, std::span<const Vec<D>>, \
                                                             const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
