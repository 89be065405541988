module;
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import :back_mesh_nodes;
import :by_element;
import :parts;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;

namespace camber {

namespace {

/// Displacements below this, in the metric, count as none: they turn axes by less than is known of them.
constexpr double negligible = 0.01;
/// Scaled Jacobian below which an element of the back mesh counts as folded.
constexpr double min_back_jacobian = 0.1;

template <int D>
LagrangeNode<D> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
}

}  // namespace

template <int D>
Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                  std::span<const LagrangeNode<D>> extended,
                                                  const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<LagrangeNode<D>>> {
        Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
        auto done = each_chunk(execution, nodes.size(), [&](std::size_t begin, std::size_t end) {
            // Of each edge that moves its displacement, in the metrics of both ends.
            std::vector<std::size_t> moved;
            std::vector<LogMetric<D>> metrics;
            std::vector<Vec<D>> displacements;
            for (std::size_t e = begin; e < end; ++e) {
                nodes[e] = middle_of(mesh, e);
                if (extended[e] == nodes[e]) continue;
                moved.push_back(e);
                for (const VertexId v : mesh.edges.vertices[e]) {
                    metrics.push_back(log_metrics[v]);
                    displacements.push_back(extended[e].point - nodes[e].point);
                }
            }
            std::vector<double> lengths(metrics.size());
            metric_norms<D>(metrics, displacements, lengths);
            for (std::size_t i = 0; i < moved.size(); ++i)
                if (!(lengths[2 * i] < negligible && lengths[2 * i + 1] < negligible))
                    nodes[moved[i]] = extended[moved[i]];
        });
        if (!done) return fail(done.error());
        return nodes;
    });
}

namespace {

template <int D>
Outcome<Buffer<Vec<D>>> displacements_of(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                         const Execution& execution) {
    return map_each(execution, mesh.edges.size(),
                    [&](std::size_t e) { return nodes[e].point - middle_of(mesh, e).point; });
}

}  // namespace

template <int D>
Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, BetweenParts<D>& between,
                                 const Execution& execution) {
    return guarded([&]() -> Outcome<Done> {
        std::vector<Buffer<Vec<D>>> displacements;
        std::vector<PartOffsets<D>> offsets;
        for (const PartNodes<D>& of : parts) {
            auto displaced = displacements_of<D>(of.mesh, of.nodes, part_of(execution, 0, 0.5));
            if (!displaced) return fail(displaced.error());
            displacements.push_back(std::move(*displaced));
        }
        offsets.reserve(parts.size());
        for (std::size_t p = 0; p < parts.size(); ++p)
            offsets.push_back({parts[p].mesh, {}, parts[p].shells, parts[p].owned, displacements[p]});
        const auto limited = limit_by_jacobian<D>(offsets, min_back_jacobian, between, part_of(execution, 0.5, 0.8));
        if (!limited) return fail(limited.error());
        for (std::size_t p = 0; p < parts.size(); ++p) {
            const std::span<LagrangeNode<D>> nodes = parts[p].nodes;
            auto done = each(part_of(execution, 0.8, 1), nodes.size(), [&](std::size_t e) {
                const Vec<D>& u = displacements[p][e];
                const Vec<D> middle = middle_of(parts[p].mesh, e).point;
                if (u != nodes[e].point - middle) nodes[e] = {middle + u};
            });
            if (!done) return done;
        }
        return Done{};
    });
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                                 const Incidence<ElementId>& shells, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<LagrangeNode<D>>> {
        Buffer<LagrangeNode<D>> limited(nodes.begin(), nodes.end());
        OnePart<D> alone;
        const PartNodes<D> all{mesh, shells, whole(mesh.linear), limited};
        auto done = limit_to_back_mesh<D>(std::span(&all, 1), alone, execution);
        if (!done) return fail(done.error());
        return limited;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes<D>(                                                   \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Column<LogMetric<D>>&, const Execution&);   \
    template Outcome<Done> limit_to_back_mesh<D>(std::span<const PartNodes<D>>, BetweenParts<D>&, const Execution&); \
    template Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes<D>(                                                    \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Incidence<ElementId>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
