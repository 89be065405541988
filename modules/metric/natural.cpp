module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
using Corners = std::array<Vec<D>, D + 1>;

template <int D>
Corners<D> corners_of(const LinearMesh<D>& mesh, std::size_t e) {
    Corners<D> p;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
    return p;
}

/// D! times the volume, with its sign.
template <int D>
double determinant(const Corners<D>& p) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = p[i + 1] - p[0];
    return det(sides);
}

/// The natural metrics of all elements.
template <int D>
Outcome<Buffer<LogMetric<D>>> of_elements(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<LogMetric<D>>> {
        Buffer<LogMetric<D>> logs(mesh.elements.size());
        auto done = each_chunk(execution, logs.size(), [&](std::size_t begin, std::size_t end) {
            std::vector<Corners<D>> simplices;
            simplices.reserve(end - begin);
            for (std::size_t e = begin; e < end; ++e) simplices.push_back(corners_of(mesh, e));
            natural_log_metrics<D>(simplices, {logs.data() + begin, end - begin});
        });
        if (!done) return fail(done.error());
        return logs;
    });
}

/// The mean over the ball of a vertex of `log_of(element)`, weighted by volume.
template <int D>
LogMetric<D> mean_over(const LinearMesh<D>& mesh, std::span<const ElementId> ball, const auto& log_of) {
    Sym<D> sum;
    double weight = 0;
    for (const ElementId e : ball) {
        const LogMetric<D>& log_metric = log_of(e);
        if (!std::isfinite(trace(log_metric.l))) continue;  // flat: has no metric
        const double volume = std::abs(determinant<D>(corners_of(mesh, e.index())));
        sum += volume * log_metric.l;
        weight += volume;
    }
    return {weight > 0 ? sum * (1 / weight) : sum};
}

/// The element's corners as the tangents of its edges at corner v tell them; none where its edges are straight there.
template <int D>
std::optional<std::array<Vec<D>, D + 1>> tangent_simplex(const QuadraticMesh<D>& mesh, ElementId e, int v) {
    const auto& corners = mesh.linear.elements.vertices[e];
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = mesh.linear.points[corners[i]];
    std::array<Vec<D>, D + 1> bent = p;
    bool is_bent = false;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != v && j != v) continue;
        const Vec<D> u = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point - midpoint(p[i], p[j]);
        if (norm_squared(u) == 0) continue;
        bent[i == v ? j : i] += 4 * u;
        is_bent = true;
    }
    if (!is_bent) return {};
    constexpr double flattened = 0.05;
    if (!(determinant<D>(bent) / determinant<D>(p) > flattened)) return {};
    return bent;
}

}  // namespace

template <int D>
Outcome<Buffer<LogMetric<D>>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                         const Incidence<ElementId>& balls,
                                                         const Execution& execution) {
    const LinearMesh<D>& linear = mesh.linear;
    const auto straight = of_elements(linear, execution);
    if (!straight) return straight;
    return guarded([&]() -> Outcome<Buffer<LogMetric<D>>> {
        Buffer<LogMetric<D>> logs(linear.points.size());
        auto done = each_chunk(
            execution, logs.size(),
            [&](std::size_t begin, std::size_t end) {
                // What the curved ones among the elements of each ball count as, in the order of the balls.
                std::vector<Corners<D>> simplices;
                std::vector<char> is_curved;
                for (std::size_t v = begin; v < end; ++v)
                    for (const ElementId e : balls[v]) {
                        const auto& corners = linear.elements.vertices[e];
                        const auto corner = std::find(corners.begin(), corners.end(), VertexId(v)) - corners.begin();
                        const auto bent = tangent_simplex(mesh, e, static_cast<int>(corner));
                        is_curved.push_back(bent.has_value());
                        if (bent) simplices.push_back(*bent);
                    }
                std::vector<LogMetric<D>> curved(simplices.size());
                natural_log_metrics<D>(simplices, curved);
                std::size_t item = 0, next = 0;
                for (std::size_t v = begin; v < end; ++v)
                    logs[v] = mean_over(linear, balls[v], [&](ElementId e) -> const LogMetric<D>& {
                        return is_curved[item++] ? curved[next++] : (*straight)[e.index()];
                    });
            },
            64);
        if (!done) return fail(done.error());
        return logs;
    });
}

template <int D>
Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution) {
    const auto logs = of_elements(mesh, execution);
    if (!logs) return logs;
    return map_each(execution, mesh.points.size(), [&](std::size_t v) {
        return mean_over(mesh, balls[v], [&](ElementId e) -> const LogMetric<D>& { return (*logs)[e.index()]; });
    });
}

template Outcome<Buffer<LogMetric<2>>> natural_log_metrics<2>(const LinearMesh<2>&, const Incidence<ElementId>&,
                                                              const Execution&);
template Outcome<Buffer<LogMetric<3>>> natural_log_metrics<3>(const LinearMesh<3>&, const Incidence<ElementId>&,
                                                              const Execution&);

template Outcome<Buffer<LogMetric<2>>> curved_natural_log_metrics<2>(const QuadraticMesh<2>&,
                                                                     const Incidence<ElementId>&, const Execution&);
template Outcome<Buffer<LogMetric<3>>> curved_natural_log_metrics<3>(const QuadraticMesh<3>&,
                                                                     const Incidence<ElementId>&, const Execution&);

}  // namespace camber
