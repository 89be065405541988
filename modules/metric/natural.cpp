module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
struct WeightedLog {
    LogMetric<D> log_metric;
    double volume = 0;
};

template <int D>
WeightedLog<D> element_log_metric(const LinearMesh<D>& mesh, std::size_t e) {
    std::array<Vec<D>, D + 1> p;
    Mat<D> j;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
    for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
    return {natural_log_metric<D>(p), std::abs(det(j))};
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
    const auto determinant = [](const std::array<Vec<D>, D + 1>& q) {
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = q[i + 1] - q[0];
        return det(sides);
    };
    constexpr double flattened = 0.05;
    if (!(determinant(bent) / determinant(p) > flattened)) return {};
    return bent;
}

}  // namespace

template <int D>
Outcome<Buffer<LogMetric<D>>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                         const Incidence<ElementId>& balls,
                                                         const Execution& execution) {
    const auto of_elements = map_each(execution, mesh.linear.elements.size(),
                                      [&](std::size_t e) { return element_log_metric(mesh.linear, e); });
    if (!of_elements) return fail(of_elements.error());
    return map_each(execution, mesh.linear.points.size(), [&](std::size_t v) {
        Sym<D> sum;
        double weight = 0;
        for (const ElementId e : balls[v]) {
            auto [log_metric, volume] = (*of_elements)[e.index()];
            const auto& corners = mesh.linear.elements.vertices[e];
            const auto corner =
                static_cast<int>(std::find(corners.begin(), corners.end(), VertexId(v)) - corners.begin());
            if (const auto bent = tangent_simplex(mesh, e, corner)) log_metric = natural_log_metric<D>(*bent);
            if (!std::isfinite(trace(log_metric.l))) continue;  // flat: has no metric
            sum += volume * log_metric.l;
            weight += volume;
        }
        return LogMetric<D>{weight > 0 ? sum * (1 / weight) : sum};
    });
}

template <int D>
Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution) {
    auto of_elements =
        map_each(execution, mesh.elements.size(), [&](std::size_t e) { return element_log_metric(mesh, e); });
    if (!of_elements) return fail(of_elements.error());
    return map_each(execution, mesh.points.size(), [&](std::size_t v) {
        Sym<D> sum;
        double weight = 0;
        for (const ElementId e : balls[v]) {
            const auto& [log_metric, volume] = (*of_elements)[e.index()];
            if (!std::isfinite(trace(log_metric.l))) continue;  // flat: has no metric
            sum += volume * log_metric.l;
            weight += volume;
        }
        return LogMetric<D>{weight > 0 ? sum * (1 / weight) : sum};
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
