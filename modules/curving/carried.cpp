module;
#include <array>
#include <cstddef>
#include <span>
module camber.curving;
import :by_element;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;

namespace camber {

namespace {

/// Displacements below this, in the metric, count as none: they turn axes by less than is known of them.
constexpr double negligible = 0.01;
/// Scaled Jacobian below which an element of the back mesh counts as folded.
constexpr double least_back_jacobian = 0.1;

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
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const LagrangeNode<D> middle = middle_of(mesh, e);
        const Vec<D> u = extended[e].point - middle.point;
        for (const VertexId v : mesh.edges.vertices[e])
            if (!(SpectralMetric<D>(log_metrics[v]).length_squared(u) < negligible * negligible)) return extended[e];
        return middle;
    });
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> carried_nodes(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                               const Incidence<ElementId>& shells, const Execution& execution) {
    auto middles = map_each(execution, mesh.edges.size(), [&](std::size_t e) { return middle_of(mesh, e); });
    if (!middles) return middles;
    auto displacements =
        map_each(execution, mesh.edges.size(), [&](std::size_t e) { return nodes[e].point - (*middles)[e].point; });
    if (!displacements) return fail(displacements.error());
    const auto lessened = lessen_by_element<D>(mesh, *middles, shells, least_back_jacobian, *displacements, execution);
    if (!lessened) return fail(lessened.error());
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const Vec<D>& u = (*displacements)[e];
        const bool whole = u == nodes[e].point - (*middles)[e].point;
        return whole ? nodes[e] : LagrangeNode<D>{(*middles)[e].point + u};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes<D>(                                                 \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Column<LogMetric<D>>&, const Execution&); \
    template Outcome<Buffer<LagrangeNode<D>>> carried_nodes<D>(                                                    \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Incidence<ElementId>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
