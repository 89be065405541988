module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<Column<LogMetric<D>>> as_column(Outcome<Buffer<LogMetric<D>>> buffer) {
    if (!buffer) return fail(std::move(buffer.error()));
    return Column<LogMetric<D>>(std::move(*buffer));
}

/// Returns the divided difference exp[x_0, …, x_n]. If the x_i differ by more than 1, the recurrence is stable.
/// Otherwise the function sums the series e^m Σ_k h_k(x − m)/(k + n)!, with the mean m and the complete homogeneous
/// symmetric polynomials h_k.
template <std::size_t M>
double exp_divided(std::array<double, M> x) {
    std::sort(x.begin(), x.end());
    if constexpr (M > 1) {
        if (const double spread = x[M - 1] - x[0]; spread > 1) {
            std::array<double, M - 1> low{};
            std::array<double, M - 1> high{};
            std::copy(x.begin(), x.end() - 1, low.begin());
            std::copy(x.begin() + 1, x.end(), high.begin());
            return (exp_divided(high) - exp_divided(low)) / spread;
        }
    }
    double mean = 0;
    for (const double v : x) mean += v / static_cast<double>(M);
    // The loop adds one value x_j at a time. Let h_k(j) be the polynomial of the first j values: h_k(j) = h_k(j − 1) +
    // x_j h_{k−1}(j).
    constexpr std::size_t terms = 18;
    std::array<double, terms> h{};
    h[0] = 1;
    for (const double v : x)
        for (std::size_t k = 1; k < terms; ++k) h[k] += (v - mean) * h[k - 1];
    double factorial = 1;
    for (std::size_t i = 2; i < M; ++i) factorial *= static_cast<double>(i);
    double sum = 0;
    for (std::size_t k = 0; k < terms; ++k) {
        sum += h[k] / factorial;
        factorial *= static_cast<double>(k + M);
    }
    return exp(mean) * sum;
}

/// Evaluates the series of the function above for eight tuples. The values of each tuple must be close.
template <std::size_t M>
[[nodiscard, gnu::always_inline]] inline Pack exp_divided(const std::array<Pack, M>& x) {
    Pack mean = packed(0);
    for (const Pack v : x) mean += v / static_cast<double>(M);
    constexpr std::size_t terms = 18;
    std::array<Pack, terms> h{};
    h[0] = packed(1);
    for (const Pack v : x)
        for (std::size_t k = 1; k < terms; ++k) h[k] += (v - mean) * h[k - 1];
    double factorial = 1;
    for (std::size_t i = 2; i < M; ++i) factorial *= static_cast<double>(i);
    Pack sum = packed(0);
    for (std::size_t k = 0; k < terms; ++k) {
        sum += h[k] / factorial;
        factorial *= static_cast<double>(k + M);
    }
    return exp(mean) * sum;
}

template <int D>
struct DensityElement {
    std::array<double, D + 1> f{};
    double volume = 0;
};
template <int D>
DensityElement<D> density_element(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field, std::size_t e) {
    const auto& v = mesh.elements.vertices[e];
    DensityElement<D> element{};
    Mat<D> sides;
    for (int i = 0; i <= D; ++i) element.f[i] = 0.5 * trace(field[v[i]].l);
    for (int i = 0; i < D; ++i) sides.column[i] = mesh.points[v[i + 1]] - mesh.points[v[0]];
    element.volume = std::abs(det(sides));
    return element;
}

template <int D>
void add_complexities(std::span<const DensityElement<D>> elements, double& sum) {
    using Element = DensityElement<D>;
    std::array<double, pack_size> divided{};
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        std::array<Pack, D + 1> f{};
        for (int i = 0; i <= D; ++i)
            f[i] = gathered(elements, 0, [&](const Element& e) __attribute__((always_inline)) { return e.f[i]; });
        const Pack near = exp_divided<D + 1>(f);
        for (std::size_t lane = 0; lane < pack_size; ++lane) divided[lane] = near[lane];
    });
    for (std::size_t i = 0; i < elements.size(); ++i) {
        const auto& f = elements[i].f;
        const auto [low, high] = std::minmax_element(f.begin(), f.end());
        sum += elements[i].volume * (*high - *low <= 1 ? divided[i] : exp_divided(f));
    }
}

template <int D>
double largest_spread(std::span<const LogMetric<D>> field) {
    double most = 0;
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        const EigenPack<D> e = eigen_system<D>(gathered_sym<D>(
            field, 0, [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; }));
        Pack low = e.values[0];
        Pack high = e.values[0];
        for (int i = 1; i < D; ++i) {
            low = min(low, e.values[i]);
            high = max(high, e.values[i]);
        }
        const Pack spread = high - low;
        for (std::size_t lane = 0; lane < pack_size; ++lane) most = std::max<double>(most, spread[lane]);
    });
    return most;
}

std::string check(const MetricBounds& b) {
    if (!(b.min_size >= 0)) return "min_size must not be negative";
    if (!(b.max_size > 0) || b.max_size < b.min_size) return "max_size must be positive and at least min_size";
    if (!(b.max_anisotropy >= 1)) return "max_anisotropy must be at least 1";
    return {};
}

template <int D>
std::optional<double> size_out_of_range(const LogMetric<D>& log_metric) {
    const double least = -2 * log(max_length), most = -2 * log(min_length);
    // No |eigenvalue| exceeds the norm of log M, so most metrics need no decomposition. `slack` covers rounding errors
    // of sizes equal to a limit.
    constexpr double slack = 1e-12;
    if (norm(log_metric.l) < std::fmin(-least, most)) return {};
    for (const double x : eigen_system(log_metric.l).values.c)
        if (!(x > least * (1 + slack) && x < most * (1 + slack))) return exp(-x / 2);
    return {};
}

}  // namespace

template <int D>
Outcome<Done> check_sizes(const Column<LogMetric<D>>& field, const Execution& execution) {
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    const auto first = reduce_each(
        execution, field.size(), none,
        [&](std::size_t& at, std::size_t v) {
            if (at == none && size_out_of_range(field[v])) at = v;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == none) return Done{};
    const double size = *size_out_of_range(field[*first]);
    std::ostringstream what;
    if (std::isfinite(size))
        what << "a size of " << size << " is not between 1e-60 and 1e60";
    else
        what << "has sizes that are not between 1e-60 and 1e60";
    static_assert(min_length == 1e-60 && max_length == 1e60);
    return fail(ErrorKind::input, what.str(), {}, Entity{"metric at vertex", *first + 1}, "use another unit of length");
}

template <int D>
LogMetric<D> apply_bounds(const LogMetric<D>& log_metric, const MetricBounds& bounds) {
    EigenSystem<D> e = eigen_system(log_metric.l);
    const double least = -2 * log(bounds.max_size);
    const double most = -2 * log(bounds.min_size);
    bool changed = false;
    for (double& x : e.values.c) {
        const double clamped = std::clamp(x, least, most);
        changed = changed || clamped != x;
        x = clamped;
    }
    const double top = *std::max_element(e.values.c.begin(), e.values.c.end());
    for (double& x : e.values.c) {
        const double raised = std::max(x, top - 2 * log(bounds.max_anisotropy));
        changed = changed || raised != x;
        x = raised;
    }
    return changed ? LogMetric<D>{composed(e)} : log_metric;
}

template <int D>
Outcome<Column<LogMetric<D>>> apply_bounds(const Column<LogMetric<D>>& field, const MetricBounds& bounds,
                                           const Execution& execution) {
    if (std::string wrong = check(bounds); !wrong.empty()) return fail(ErrorKind::usage, std::move(wrong));
    return as_column<D>(
        map_each(execution, field.size(), [&](std::size_t v) { return apply_bounds(field[v], bounds); }));
}

template <int D>
Outcome<Column<LogMetric<D>>> intersection(const Column<LogMetric<D>>& a, const Column<LogMetric<D>>& b,
                                           const Execution& execution) {
    if (a.size() != b.size()) return fail(ErrorKind::usage, "the metrics belong to different meshes");
    return as_column<D>(map_each(execution, a.size(), [&](std::size_t v) { return intersection(a[v], b[v]); }));
}

namespace {

/// Returns ½ log det of the metric's restriction to the plane of the triangle.
double log_density(const LogMetric<3>& log_metric, const TriangleFrame& frame) {
    const Sym<3> m = exp(log_metric).m;
    const auto& [s, t] = frame.tangents;
    const double st = dot(s, m * t);
    return log(dot(s, m * s) * dot(t, m * t) - st * st) / 2;
}

Outcome<double> surface_complexity(const LinearMesh<3>& mesh, const Column<LogMetric<3>>& field,
                                   const Execution& execution) {
    return reduce_each(
        execution, mesh.facets.size(), 0.0,
        [&](double& sum, std::size_t f) {
            const TriangleFrame frame = triangle_frame(triangle_corners(mesh, f));
            if (!(frame.area > 0)) return;
            std::array<double, 3> density{};
            for (int i = 0; i < 3; ++i) density[i] = log_density(field[mesh.facets.vertices[f][i]], frame);
            sum += 2 * frame.area * exp_divided<3>(density);
        },
        [](double x, double y) { return x + y; });
}

}  // namespace

template <int D>
Outcome<double> complexity(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field, const Execution& execution) {
    if (field.size() != mesh.points.size()) return fail(ErrorKind::usage, "the metric belongs to another mesh");
    if constexpr (D == 3)
        if (is_standalone_surface(mesh)) return surface_complexity(mesh, field, execution);
    const std::size_t n = mesh.elements.size();
    constexpr std::size_t grain = 512;
    return reduce_each(
        execution, (n + pack_size - 1) / pack_size, 0.0,
        [&](double& sum, std::size_t pack) {
            std::array<DensityElement<D>, pack_size> elements;
            const std::size_t begin = pack * pack_size;
            const std::size_t count = std::min<std::size_t>(pack_size, n - begin);
            for (std::size_t i = 0; i < count; ++i) elements[i] = density_element(mesh, field, begin + i);
            add_complexities<D>({elements.data(), count}, sum);
        },
        [](double x, double y) { return x + y; }, grain);
}

template <int D>
Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution) {
    const std::size_t n = field.size();
    const auto spread = reduce_each(
        execution, (n + pack_size - 1) / pack_size, 0.0,
        [&](double& most, std::size_t pack) {
            const std::size_t begin = pack * pack_size;
            most = std::max(
                most, largest_spread<D>(field.view().subspan(begin, std::min<std::size_t>(pack_size, n - begin))));
        },
        [](double a, double b) { return std::max(a, b); }, 512);
    if (!spread) return fail(spread.error());
    return exp(*spread / 2);
}

template <int D>
Outcome<Column<LogMetric<D>>> scale_to_complexity(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field,
                                                  double target, const Execution& execution) {
    if (!(target > 0) || !std::isfinite(target))
        return fail(ErrorKind::usage, "the target complexity must be positive and finite");
    const auto now = complexity(mesh, field, part_of(execution, 0, 0.9));
    if (!now) return fail(now.error());
    if (!(*now > 0) || !std::isfinite(*now))
        return fail(ErrorKind::usage, "the metric's complexity is " + std::to_string(*now) + ": it cannot be scaled",
                    {}, {}, "bound its sizes first");
    const int dimension = is_standalone_surface(mesh) ? 2 : D;
    const Sym<D> shift = 2.0 / dimension * log(target / *now) * Sym<D>::identity();
    return as_column<D>(map_each(part_of(execution, 0.9, 1), field.size(),
                                 [&](std::size_t v) { return LogMetric<D>{field[v].l + shift}; }));
}

namespace {

Outcome<Done> check_gradation_options(const GradationOptions& options) {
    if (!(options.tolerance >= 0)) return fail(ErrorKind::usage, "the gradation's tolerance must not be negative");
    return check_limits(options);
}

template <int D>
Incidence<VertexId> adjacent(const EdgeSet<D>& edges, std::size_t vertices) {
    Buffer<std::uint32_t> offsets(vertices + 1, 0U);
    for (const auto& [a, b] : edges.vertices) {
        ++offsets[a.index() + 1];
        ++offsets[b.index() + 1];
    }
    for (std::size_t v = 0; v < vertices; ++v) offsets[v + 1] += offsets[v];
    Buffer<VertexId> items(2 * edges.size());
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    for (const auto& [a, b] : edges.vertices) {
        items[next[a.index()]++] = b;
        items[next[b.index()]++] = a;
    }
    for (std::size_t v = 0; v < vertices; ++v) std::sort(items.begin() + offsets[v], items.begin() + offsets[v + 1]);
    return {Column<std::uint32_t>(std::move(offsets)), Column<VertexId>(std::move(items))};
}

template <int D>
bool surely_contained(const EigenSystem<D>& metric, const EigenSystem<D>& spanned) {
    return *std::max_element(spanned.values.c.begin(), spanned.values.c.end()) <=
           *std::min_element(metric.values.c.begin(), metric.values.c.end());
}

template <int D>
struct Swept {
    EigenSystem<D> metric;
    bool changed = false;
};

template <int D>
Outcome<Done> check_inputs(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Column<LogMetric<D>>& field,
                           const GradationOptions& options) {
    if (auto checked = check_gradation_options(options); !checked) return checked;
    if (field.size() != mesh.points.size() || edges.of_elements.size() != mesh.elements.size())
        return fail(ErrorKind::usage, "the metric or the edges belong to another mesh");
    return Done{};
}

template <int D>
Outcome<Buffer<EigenSystem<D>>> decomposed(const Column<LogMetric<D>>& field, const Execution& execution) {
    return map_each(execution, field.size(), [&](std::size_t v) { return eigen_system(field[v].l); });
}

}  // namespace

template <int D>
EigenSystem<D> spanned_metric(const EigenSystem<D>& at_p, const AxesTurn<D>& turn, const Vec<D>& pq,
                              const GradationOptions& options) {
    const double growth = log(options.ratio);
    const double metric_length = std::sqrt(SpectralMetric<D>(turned(at_p, turn.by(0.5))).length_squared(pq));
    const double metric_part = log1p(metric_length * growth);
    const double share = options.space == GradationSpace::metric     ? 0
                         : options.space == GradationSpace::physical ? 1
                                                                     : options.physical_share;
    EigenSystem<D> out = turned(at_p, turn);
    const double distance_in_space = norm(pq);
    for (double& log_value : out.values.c) {
        // If the size h = e^{−λ/2} grows by a factor g, the log-eigenvalue λ falls by 2 log g.
        const double physical_part = share > 0 ? log1p(distance_in_space * exp(log_value / 2) * growth) : 0;
        log_value -= 2 * (share * physical_part + (1 - share) * metric_part);
    }
    return out;
}

template <int D>
Outcome<Graded<D>> apply_gradation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const Column<LogMetric<D>>& field, const GradationOptions& options,
                                   const Execution& execution) {
    if (auto sound = check_inputs(mesh, edges, field, options); !sound) return fail(sound.error());
    const std::size_t n = mesh.points.size();
    const Incidence<VertexId> around = adjacent(edges, n);
    const Execution quiet = without_progress(execution);
    auto metrics = decomposed<D>(field, quiet);
    if (!metrics) return fail(metrics.error());
    Buffer<Sym<D>> logs_now(n);
    for (std::size_t v = 0; v < n; ++v) logs_now[v] = field[v].l;
    Buffer<std::uint8_t> active(n, std::uint8_t{1});   // 1: the metric changed in the last sweep
    Buffer<std::uint8_t> touched(n, std::uint8_t{0});  // 1: the metric changed in any sweep

    const auto swept = [&](std::size_t v) {
        Swept<D> out{(*metrics)[v], false};
        for (const VertexId w : around[v]) {
            // The metric that w spans at v depends on both metrics, because the axes rotate from w to v. It is
            // unchanged if neither metric changed.
            if (active[w.index()] == 0 && active[v] == 0) continue;
            const auto spanned =
                spanned_metric<D>((*metrics)[w.index()], turn_between(logs_now[w.index()], logs_now[v]),
                                  mesh.points[v] - mesh.points[w], options);
            if (surely_contained<D>(out.metric, spanned) || size_excess<D>(out.metric, spanned) <= options.tolerance)
                continue;
            out.metric = intersection<D>(out.metric, spanned);
            out.changed = true;
        }
        return out;
    };
    Graded<D> result;
    for (;; ++result.sweeps) {
        auto next = map_each(quiet, n, swept);
        if (!next) return fail(next.error());
        report_progress(execution, static_cast<std::size_t>(result.sweeps) + 1,
                        static_cast<std::size_t>(options.max_sweeps) + 1);
        bool any = false;
        for (std::size_t v = 0; v < n; ++v) {
            active[v] = (*next)[v].changed ? 1 : 0;
            if (active[v] != 0) logs_now[v] = composed((*next)[v].metric);
            (*metrics)[v] = (*next)[v].metric;
            touched[v] |= active[v];
            any = any || active[v] != 0;
        }
        result.converged = !any;
        if (!any || result.sweeps == options.max_sweeps) break;
    }
    auto logs =
        map_each(quiet, n, [&](std::size_t v) { return touched[v] != 0 ? LogMetric<D>{logs_now[v]} : field[v]; });
    if (!logs) return fail(logs.error());
    result.log_metrics = std::move(*logs);
    for (const std::uint8_t t : touched) result.changed += t;
    return result;
}

template <int D>
Outcome<double> gradation_excess(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Column<LogMetric<D>>& field,
                                 const GradationOptions& options, const Execution& execution) {
    if (auto sound = check_inputs(mesh, edges, field, options); !sound) return fail(sound.error());
    const auto metrics = decomposed<D>(field, part_of(execution, 0, 0.5));
    if (!metrics) return fail(metrics.error());
    return reduce_each(
        part_of(execution, 0.5, 1), edges.size(), -1e300,
        [&](double& most, std::size_t e) {
            const auto& [a, b] = edges.vertices[e];
            for (const auto& [p, q] : {std::array{a, b}, std::array{b, a}}) {
                const auto spanned = spanned_metric<D>((*metrics)[p.index()], turn_between(field[p].l, field[q].l),
                                                       mesh.points[q] - mesh.points[p], options);
                most = std::max(most, size_excess<D>((*metrics)[q.index()], spanned));
            }
        },
        [](double x, double y) { return std::max(x, y); });
}

namespace {

template <int D>
LogMetric<D> thin_along(const Vec<D>& normal, double tangent_size, double normal_size) {
    const double tangential = -2 * log(tangent_size);
    const double difference = -2 * log(normal_size) - tangential;
    LogMetric<D> out{tangential * Sym<D>::identity()};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) out.l(i, j) += difference * normal[i] * normal[j];
    return out;
}

}  // namespace

template <int D>
Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals, const SurfaceMetricOptions& options,
                                                  const Execution& execution) {
    const double volume_size = options.volume_size.value_or(options.tangent_size);
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    if (!(volume_size > 0) || !std::isfinite(volume_size))
        return fail(ErrorKind::usage, "volume_size must be a finite number above 0");
    auto logs = map_each(execution, normals.size(), [&](std::size_t v) {
        LogMetric<D> out{-2 * log(volume_size) * Sym<D>::identity()};
        bool on_boundary = false;
        for (const Vec<D>& direction : normals[v]) {
            const double length = norm(direction);
            if (!(length > 0)) continue;
            const LogMetric<D> side = thin_along(direction / length, options.tangent_size, options.normal_size);
            out = on_boundary ? intersection(out, side) : side;
            on_boundary = true;
        }
        return out;
    });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template LogMetric<D> apply_bounds<D>(const LogMetric<D>&, const MetricBounds&);                                   \
    template Outcome<Column<LogMetric<D>>> apply_bounds<D>(const Column<LogMetric<D>>&, const MetricBounds&,           \
                                                           const Execution&);                                          \
    template Outcome<Column<LogMetric<D>>> intersection<D>(const Column<LogMetric<D>>&, const Column<LogMetric<D>>&,   \
                                                           const Execution&);                                          \
    template Outcome<Done> check_sizes<D>(const Column<LogMetric<D>>&, const Execution&);                              \
    template Outcome<double> complexity<D>(const LinearMesh<D>&, const Column<LogMetric<D>>&, const Execution&);       \
    template Outcome<double> largest_anisotropy<D>(const Column<LogMetric<D>>&, const Execution&);                     \
    template Outcome<Column<LogMetric<D>>> scale_to_complexity<D>(const LinearMesh<D>&, const Column<LogMetric<D>>&,   \
                                                                  double, const Execution&);                           \
    template EigenSystem<D> spanned_metric<D>(const EigenSystem<D>&, const AxesTurn<D>&, const Vec<D>&,                \
                                              const GradationOptions&);                                                \
    template Outcome<Graded<D>> apply_gradation<D>(const LinearMesh<D>&, const EdgeSet<D>&,                            \
                                                   const Column<LogMetric<D>>&, const GradationOptions&,               \
                                                   const Execution&);                                                  \
    template Outcome<double> gradation_excess<D>(const LinearMesh<D>&, const EdgeSet<D>&, const Column<LogMetric<D>>&, \
                                                 const GradationOptions&, const Execution&);                           \
    template Outcome<Column<LogMetric<D>>> surface_log_metrics<D>(const VertexNormals<D>&,                             \
                                                                  const SurfaceMetricOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
