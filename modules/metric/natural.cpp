module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>
module camber.metric;
import :ball_sums;
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

/// What an element has to add at a corner to the mean there; a flat one has no metric, and nothing to add.
template <int D>
struct Part {
    Sym<D> weighted;
    double volume = 0;
    bool counts = false;

    Part() = default;
    Part(const LogMetric<D>& log_metric, double of_volume)
        : weighted(of_volume * log_metric.l), volume(of_volume), counts(std::isfinite(trace(log_metric.l))) {}
};
template <int D>
using Parts = std::array<Part<D>, D + 1>;

/// Of each vertex the mean of what the elements around it have to add: make(begin, end, parts), as in sum_over_balls.
template <int D>
Outcome<Buffer<LogMetric<D>>> means(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                    const Execution& execution, const auto& make) {
    return guarded([&]() -> Outcome<Buffer<LogMetric<D>>> {
        Buffer<LogMetric<D>> logs(mesh.points.size(), LogMetric<D>{});
        Buffer<double> volumes(mesh.points.size(), 0.0);
        auto summed = sum_over_balls<Part<D>>(mesh, balls, execution, make, [&](VertexId v, const Part<D>& part) {
            if (!part.counts) return;
            logs[v.index()].l += part.weighted;
            volumes[v.index()] += part.volume;
        });
        if (!summed) return fail(summed.error());
        for (std::size_t v = 0; v < logs.size(); ++v)
            if (volumes[v] > 0) logs[v].l *= 1 / volumes[v];
        return logs;
    });
}

/// The displacements of the edges' nodes off the middles of their chords.
template <int D>
using Displacements = std::array<Vec<D>, edges_per_simplex<D>>;

template <int D>
Displacements<D> displacements_of(const QuadraticMesh<D>& mesh, ElementId e, const Corners<D>& p) {
    Displacements<D> u;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        u[k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point - midpoint(p[i], p[j]);
    }
    return u;
}

/// The element's corners as the tangents of its edges at corner v tell them; none where its edges are straight there.
template <int D>
std::optional<Corners<D>> tangent_simplex(const Corners<D>& p, const Displacements<D>& u, double volume, int v) {
    Corners<D> bent = p;
    bool is_bent = false;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if ((i != v && j != v) || norm_squared(u[k]) == 0) continue;
        bent[i == v ? j : i] += 4 * u[k];
        is_bent = true;
    }
    if (!is_bent) return {};
    constexpr double flattened = 0.05;
    if (!(determinant<D>(bent) / volume > flattened)) return {};
    return bent;
}

/// Elements of a chunk as simplices, each found once: what the elements' corners count as.
template <int D>
struct SeenSimplices {
    std::vector<Corners<D>> simplices;
    std::vector<std::array<std::uint32_t, D + 1>> of_corners;
    std::vector<double> volumes;

    explicit SeenSimplices(std::size_t elements) {
        simplices.reserve((D + 1) * elements);
        of_corners.reserve(elements);
        volumes.reserve(elements);
    }
    void add(const QuadraticMesh<D>& mesh, ElementId e) {
        const Corners<D> p = corners_of(mesh.linear, e.index());
        const Displacements<D> u = displacements_of(mesh, e, p);
        const double volume = determinant<D>(p);
        constexpr std::uint32_t none = -1;
        std::uint32_t straight = none;
        auto& corners = of_corners.emplace_back();
        for (int v = 0; v <= D; ++v) {
            const auto bent = tangent_simplex<D>(p, u, volume, v);
            const auto next = static_cast<std::uint32_t>(simplices.size());
            if (!bent && straight == none) straight = next;
            if (bent || straight == next) simplices.push_back(bent ? *bent : p);
            corners[v] = bent ? next : straight;
        }
        volumes.push_back(std::abs(volume));
    }
};

}  // namespace

template <int D>
Outcome<Buffer<LogMetric<D>>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                         const Incidence<ElementId>& balls,
                                                         const Execution& execution) {
    return means(mesh.linear, balls, execution, [&](std::size_t begin, std::size_t end, std::span<Parts<D>> parts) {
        SeenSimplices<D> seen(end - begin);
        for (std::size_t e = begin; e < end; ++e) seen.add(mesh, ElementId(e));
        std::vector<LogMetric<D>> logs(seen.simplices.size());
        natural_log_metrics<D>(seen.simplices, logs);
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (int v = 0; v <= D; ++v) parts[i][v] = {logs[seen.of_corners[i][v]], seen.volumes[i]};
    });
}

template <int D>
Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution) {
    return means(mesh, balls, execution, [&](std::size_t begin, std::size_t end, std::span<Parts<D>> parts) {
        std::vector<Corners<D>> simplices;
        simplices.reserve(end - begin);
        for (std::size_t e = begin; e < end; ++e) simplices.push_back(corners_of(mesh, e));
        std::vector<LogMetric<D>> logs(simplices.size());
        natural_log_metrics<D>(simplices, logs);
        for (std::size_t i = 0; i < parts.size(); ++i) parts[i].fill({logs[i], std::abs(determinant<D>(simplices[i]))});
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
