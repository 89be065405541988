module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

Outcome<Done> check(const GradationOptions& options) {
    if (!(options.tolerance >= 0)) return fail(ErrorKind::usage, "the gradation's tolerance must not be negative");
    return check_limits(options);
}

/// The vertices at the other ends of the edges around each vertex, rising.
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

/// Whether all that `spanned` asks for is surely asked for by `metric`: its largest eigenvalue below the other's least.
template <int D>
bool surely_contained(const EigenSystem<D>& metric, const EigenSystem<D>& spanned) {
    return *std::max_element(spanned.values.c.begin(), spanned.values.c.end()) <=
           *std::min_element(metric.values.c.begin(), metric.values.c.end());
}

/// One vertex's share of a sweep: its metric, and whether a neighbour's asked for more.
template <int D>
struct Swept {
    EigenSystem<D> metric;
    bool changed = false;
};

template <int D>
Outcome<Done> check_sizes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Column<LogMetric<D>>& field,
                          const GradationOptions& options) {
    if (auto checked = check(options); !checked) return checked;
    if (field.size() != mesh.points.size() || edges.of_elements.size() != mesh.elements.size())
        return fail(ErrorKind::usage, "the metric or the edges are of another mesh");
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
        // h grows by a factor g: λ = h⁻², so log λ falls by 2 log g.
        const double physical_part = share > 0 ? log1p(distance_in_space * exp(log_value / 2) * growth) : 0;
        log_value -= 2 * (share * physical_part + (1 - share) * metric_part);
    }
    return out;
}

template <int D>
Outcome<Graded<D>> apply_gradation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const Column<LogMetric<D>>& field, const GradationOptions& options,
                                   const Execution& execution) {
    if (auto sound = check_sizes(mesh, edges, field, options); !sound) return fail(sound.error());
    const std::size_t n = mesh.points.size();
    const Incidence<VertexId> around = adjacent(edges, n);
    const Execution quiet = without_progress(execution);
    auto metrics = decomposed<D>(field, quiet);
    if (!metrics) return fail(metrics.error());
    Buffer<Sym<D>> logs_now(n);
    for (std::size_t v = 0; v < n; ++v) logs_now[v] = field[v].l;
    Buffer<std::uint8_t> active(n, std::uint8_t{1});   // changed in the last sweep
    Buffer<std::uint8_t> touched(n, std::uint8_t{0});  // changed in any

    const auto swept = [&](std::size_t v) {
        Swept<D> out{(*metrics)[v], false};
        for (const VertexId w : around[v]) {
            // What w spans here depends on both, since it turns along.
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
    if (auto sound = check_sizes(mesh, edges, field, options); !sound) return fail(sound.error());
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

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template EigenSystem<D> spanned_metric<D>(const EigenSystem<D>&, const AxesTurn<D>&, const Vec<D>&,                \
                                              const GradationOptions&);                                                \
    template Outcome<Graded<D>> apply_gradation<D>(const LinearMesh<D>&, const EdgeSet<D>&,                            \
                                                   const Column<LogMetric<D>>&, const GradationOptions&,               \
                                                   const Execution&);                                                  \
    template Outcome<double> gradation_excess<D>(const LinearMesh<D>&, const EdgeSet<D>&, const Column<LogMetric<D>>&, \
                                                 const GradationOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
